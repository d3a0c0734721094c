// SPDX-License-Identifier: LGPL-2.1-or-later
// Nodes with the lists of their neighbours, laid out for packs: a batch holds `lanes` centres with about as many
// neighbours each, so that one loop over neighbours serves all lanes.
#pragma once
#include <vector>

#include "framework/algebra/memory.h"
#include "framework/mesh/mesh.h"

namespace stroma {

/// Plain data; filled once. Centres of one chunk lie near each other in the order of the nodes and are sorted by the
/// length of their lists. No two batches share a centre, so batches may write to the rows of their centres at once.
struct Neighbourhoods {
  struct Batch {
    Index first = 0;    ///< where its neighbours begin in `neighbour`, in units of `lanes`
    Index valence = 0;  ///< neighbours of the longest list; shorter ones repeat their own centre
    int kind = 0;       ///< as given for its centres: all of one batch share it
  };
  int lanes = 1;
  std::vector<Batch> batches;
  std::vector<Index> chunk_start{0};  ///< batches of a chunk, shape (chunks + 1)
  Array<Index> own;                   ///< row of the centre times row_doubles, shape (batches, lanes); padding repeats
  Array<Index> neighbour;             ///< row of the neighbour times row_doubles, shape (sum of valences, lanes)
  std::vector<Index> centre;          ///< centre (a node) in a lane, -1 for padding, shape (batches, lanes)

  Index count() const { return Index(batches.size()); }
  Index chunks() const { return Index(chunk_start.size()) - 1; }
  const Index* ownOffsets(Index batch) const { return own.data() + std::size_t(batch) * std::size_t(lanes); }
  const Index* neighbourOffsets(Index batch, Index k) const {
    return neighbour.data() + std::size_t(batches[batch].first + k) * std::size_t(lanes);
  }
};

/// Centres in a chunk: some tens of microseconds of work for a thread.
constexpr Index neighbourhood_chunk = 512;

/// `neighbours` has an item for each node; nodes with an empty list are left out. `kind` (shape (nodes)) keeps centres
/// apart that need different work. `first_row` is added to nodes to give rows of the system.
Neighbourhoods arrangeNeighbourhoods(const Adjacency& neighbours, const std::vector<int>& kind, Index first_row,
                                     int lanes);

/// The lists the other way round: item j lists the nodes whose lists hold j, ascending.
Adjacency transposed(const Adjacency& lists);

}  // namespace stroma
