// SPDX-License-Identifier: LGPL-2.1-or-later
// The order in which elements are visited: batches of SIMD width, batches in blocks that are slabs of space, blocks in
// colours such that blocks of one colour share no node. Threads take blocks of one colour at a time, and every node
// receives its sums in the order colour, block, batch, lane, whatever the number of threads.
#pragma once
#include <vector>

#include "framework/scene/types.h"

namespace stroma {

struct Arrangement {
  std::vector<Index> element;       ///< shape (batches * lanes): element of each lane, -1 for padding
  std::vector<Index> block_start;   ///< shape (blocks + 1): first batch of each block
  std::vector<Index> colour_start;  ///< shape (colours + 1): first block of each colour
  Index batches = 0;
  Index elements = 0;
};

/// Arranges `count` elements of `nodes_per_element` nodes, connectivity flat in `nodes`. The order of the file
/// is kept where its pieces only touch their neighbours; other meshes are cut in slabs across the longest axis, along a
/// Morton curve inside each. The result depends on the
/// mesh and on `lanes` only.
Arrangement arrangeElements(const Index* nodes, int nodes_per_element, Index count, const std::vector<Vec3>& position,
                            int lanes);

/// The smallest block of elements with so many nodes: large enough to repay waking a thread. 4,096 pairs of tetrahedra
/// (five nodes; half of it gave two threads nothing at 17,000 tetrahedra, twice of it left 40,000 to one) and 1,600
/// hexahedra (a step of 8,000: 1.16 times faster with two threads): the work of an element grows with the pairs of its
/// nodes.
constexpr Index blockElements(int nodes_per_element) { return 102400 / (nodes_per_element * nodes_per_element); }

}  // namespace stroma
