// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/collision/box_tree.h"

#include <algorithm>
#include <numeric>

namespace stroma {

void BoxTree::build(std::vector<Box> boxes) {
  nodes_.clear();
  if (boxes.empty()) return;
  nodes_.reserve(2 * boxes.size());
  std::vector<Index> order(boxes.size());
  std::iota(order.begin(), order.end(), 0);
  makeNode(boxes, order, 0, boxes.size());
}

/// Halves by number: the depth is the logarithm of it, whatever the places.
Index BoxTree::makeNode(const std::vector<Box>& boxes, std::vector<Index>& order, std::size_t begin, std::size_t end) {
  const auto at = Index(nodes_.size());
  nodes_.emplace_back();
  Box whole, middles;
  for (std::size_t i = begin; i < end; ++i) {
    const Box& box = boxes[std::size_t(order[i])];
    whole.add(box);
    middles.add(Vec3((box.low + box.high) / 2));
  }
  nodes_[std::size_t(at)].box = whole;
  nodes_[std::size_t(at)].items = Index(end - begin);
  if (end - begin == 1) {
    nodes_[std::size_t(at)].item = order[begin];
    return at;
  }
  Eigen::Index axis = 0;
  (middles.high - middles.low).maxCoeff(&axis);
  const std::size_t half = (begin + end) / 2;
  const auto middle = [&](Index i) { return boxes[std::size_t(i)].low[axis] + boxes[std::size_t(i)].high[axis]; };
  std::nth_element(order.begin() + long(begin), order.begin() + long(half), order.begin() + long(end),
                   [&](Index a, Index b) { return middle(a) != middle(b) ? middle(a) < middle(b) : a < b; });
  const Index left = makeNode(boxes, order, begin, half), right = makeNode(boxes, order, half, end);
  nodes_[std::size_t(at)].left = left;
  nodes_[std::size_t(at)].right = right;
  return at;
}

void BoxTree::refit(const std::vector<Box>& boxes) {
  for (std::size_t i = nodes_.size(); i-- > 0;) {
    Node& node = nodes_[i];
    if (node.item >= 0) {
      node.box = boxes[std::size_t(node.item)];
    } else {
      node.box = nodes_[std::size_t(node.left)].box;
      node.box.add(nodes_[std::size_t(node.right)].box);
    }
  }
}

}  // namespace stroma
