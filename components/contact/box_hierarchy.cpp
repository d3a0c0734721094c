// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/contact/box_hierarchy.h"

#include <algorithm>
#include <numeric>

namespace stroma::contact {

void Hierarchy::build(const std::vector<Box>& items) {
  nodes_.clear();
  order_.resize(items.size());
  std::iota(order_.begin(), order_.end(), 0);
  if (!items.empty()) split(items, 0, int(items.size()));
  refit(items);
}

int Hierarchy::split(const std::vector<Box>& items, int first, int count) {
  const int index = int(nodes_.size());
  nodes_.push_back({{}, first, count, -1});
  if (count <= leaf_size) return index;
  Box middles;
  const auto middle = [&items](int item) {
    return Vec3(0.5 * (items[std::size_t(item)].low + items[std::size_t(item)].high));
  };
  for (int k = first; k < first + count; ++k) middles.add(middle(order_[std::size_t(k)]));
  int axis = 0;
  (middles.high - middles.low).maxCoeff(&axis);
  const int half = count / 2;
  const auto begin = order_.begin() + first;
  std::nth_element(begin, begin + half, begin + count, [&](int i, int j) {
    const double a = middle(i)[axis], b = middle(j)[axis];
    return a != b ? a < b : i < j;
  });
  split(items, first, half);
  const int right = split(items, first + half, count - half);
  nodes_[std::size_t(index)].right = right;
  return index;
}

void Hierarchy::refit(const std::vector<Box>& items) {
  boxes_.resize(items.size());
  for (std::size_t k = 0; k < order_.size(); ++k) boxes_[k] = items[std::size_t(order_[k])];
  for (int index = int(nodes_.size()) - 1; index >= 0; --index) fit(nodes_[std::size_t(index)], index);
}

void Hierarchy::fit(Node& node, int index) const {
  node.box = {};
  if (node.right < 0) {
    for (int k = node.first; k < node.first + node.count; ++k) node.box.add(boxes_[std::size_t(k)]);
    return;
  }
  node.box.add(nodes_[std::size_t(index) + 1].box);
  node.box.add(nodes_[std::size_t(node.right)].box);
}

}  // namespace stroma::contact
