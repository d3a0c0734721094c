// SPDX-License-Identifier: LGPL-2.1-or-later
// A tree of boxes that fixes the order in which pairs of parts are visited: that of SOFA's CubeCollisionModel and BVHNarrowPhase.
//
// A cell with more than four boxes is cut in two, `depth` times at most: its boxes are sorted by their middles along its longest side
// (x where it is the longest, y where it is longer than z, else z; boxes with the same middle keep their order), and the first half, which
// takes the odd one, becomes the first child. The order is that of the boxes of build() and stays; refit() moves the boxes alone.
// Releases of SOFA before 2025 sort with std::sort, which leaves the order of equal middles open.
//
// Pairs of cells wait on a stack. For the pair on top, the children of both are compared, the first tree's in the outer loop: two leaves
// are visited at once, everything else goes onto the stack.
#pragma once
#include <array>
#include <vector>

#include "framework/collision/box_tree.h"

namespace stroma::collision {

class HalvingTree {
 public:
  void build(const std::vector<Box>& boxes, int depth);
  /// With the order() of another tree of as many boxes.
  void build(const std::vector<Box>& boxes, int depth, const std::vector<Index>& order);
  void refit(const std::vector<Box>& boxes);
  bool empty() const { return leaves_ == 0; }
  const Box& whole() const { return cells_[std::size_t(leaves_)].box; }
  std::vector<Index> order() const;  ///< of the boxes, as leaves

  /// visit(i, j) for each box i of this tree and j of `other` that are nearer than `margin` along every axis, in SOFA's order.
  template <class Visit>
  void forEachPair(const HalvingTree& other, double margin, Visit&& visit) const {
    if (empty() || other.empty()) return;
    const Cell &first = cells_[std::size_t(leaves_)], &second = other.cells_[std::size_t(other.leaves_)];
    std::vector<std::array<Index, 4>> waiting{{first.begin, first.end, second.begin, second.end}};
    while (!waiting.empty()) {
      const std::array<Index, 4> top = waiting.back();
      waiting.pop_back();
      for (Index i = top[0]; i < top[1]; ++i)
        for (Index j = top[2]; j < top[3]; ++j) {
          const Cell &p = cells_[std::size_t(i)], &q = other.cells_[std::size_t(j)];
          if (!p.box.isNear(q.box, margin)) continue;
          if (p.item >= 0 && q.item >= 0)
            visit(p.item, q.item);
          else
            waiting.push_back({p.item >= 0 ? i : p.begin, p.item >= 0 ? i + 1 : p.end, q.item >= 0 ? j : q.begin,
                               q.item >= 0 ? j + 1 : q.end});
        }
    }
  }

 private:
  struct Cell {
    Box box{};
    Index begin = 0, end = 0;  ///< children
    Index item = -1;           ///< of a leaf: its box
  };
  void make(const std::vector<Box>& boxes, int depth, bool sorts);
  void addCell(Index begin, Index end);
  std::vector<Cell> cells_;  ///< leaves, then the whole, then level by level
  Index leaves_ = 0;
};

}  // namespace stroma::collision
