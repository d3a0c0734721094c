// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/collision/halving_tree.h"

#include <algorithm>

namespace stroma::collision {

namespace {
Eigen::Index longestSide(const Box& box) {
  const Vec3 side = box.high - box.low;
  if (side[0] > side[1]) return side[0] > side[2] ? 0 : 2;
  return side[1] > side[2] ? 1 : 2;
}
}  // namespace

void HalvingTree::build(const std::vector<Box>& boxes, int depth) {
  cells_.assign(boxes.size(), {});
  for (std::size_t i = 0; i < boxes.size(); ++i) cells_[i].item = Index(i);
  make(boxes, depth, true);
}

void HalvingTree::build(const std::vector<Box>& boxes, int depth, const std::vector<Index>& order) {
  cells_.assign(boxes.size(), {});
  for (std::size_t i = 0; i < boxes.size(); ++i) cells_[i].item = order[i];
  make(boxes, depth, false);
}

void HalvingTree::addCell(Index begin, Index end) {
  Cell cell;
  cell.begin = begin, cell.end = end;
  for (Index i = begin; i < end; ++i) cell.box.add(cells_[std::size_t(i)].box);
  cells_.push_back(cell);
}

void HalvingTree::make(const std::vector<Box>& boxes, int depth, bool sorts) {
  constexpr Index few = 4;
  leaves_ = Index(boxes.size());
  if (leaves_ == 0) return;
  for (Cell& leaf : cells_) leaf.box = boxes[std::size_t(leaf.item)];
  std::size_t at = cells_.size();
  addCell(0, leaves_);
  for (int level = 0; level < depth; ++level)
    for (const std::size_t end = cells_.size(); at < end; ++at) {
      const Cell cell = cells_[at];
      const Index count = cell.end - cell.begin;
      if (count <= few) continue;
      const Eigen::Index axis = longestSide(cell.box);
      if (sorts)
        std::stable_sort(cells_.begin() + cell.begin, cells_.begin() + cell.end, [axis](const Cell& a, const Cell& b) {
          return a.box.low[axis] + a.box.high[axis] < b.box.low[axis] + b.box.high[axis];
        });
      const Index middle = cell.begin + (count + 1) / 2;
      const Index child = Index(cells_.size());
      addCell(cell.begin, middle);
      addCell(middle, cell.end);
      cells_[at].begin = child, cells_[at].end = child + 2;
    }
}

void HalvingTree::refit(const std::vector<Box>& boxes) {
  for (Index i = 0; i < leaves_; ++i) cells_[std::size_t(i)].box = boxes[std::size_t(cells_[std::size_t(i)].item)];
  for (std::size_t i = cells_.size(); i-- > std::size_t(leaves_);) {
    Cell& cell = cells_[i];
    cell.box = {};
    for (Index child = cell.begin; child < cell.end; ++child) cell.box.add(cells_[std::size_t(child)].box);
  }
}

std::vector<Index> HalvingTree::order() const {
  std::vector<Index> order;
  for (Index i = 0; i < leaves_; ++i) order.push_back(cells_[std::size_t(i)].item);
  return order;
}

}  // namespace stroma::collision
