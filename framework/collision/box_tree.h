// SPDX-License-Identifier: LGPL-2.1-or-later
// A binary tree of bounding boxes that finds the boxes near a given one in logarithmic time. refit() keeps the shape of the
// tree when boxes move, and costs a fraction of build().
#pragma once
#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "framework/scene/types.h"

namespace stroma {

struct Box {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = Vec3::Constant(-std::numeric_limits<double>::infinity());

  void add(const Vec3& p) { low = low.cwiseMin(p), high = high.cwiseMax(p); }
  void add(const Box& other) { low = low.cwiseMin(other.low), high = high.cwiseMax(other.high); }
  Box grownBy(double margin) const { return {low.array() - margin, high.array() + margin}; }
  bool meets(const Box& other) const {
    return (low.array() <= other.high.array()).all() && (other.low.array() <= high.array()).all();
  }
  double distanceTo(const Vec3& p) const { return (p - p.cwiseMax(low).cwiseMin(high)).norm(); }
  /// Nearer than `margin` along every axis.
  bool isNear(const Box& other, double margin) const {
    return (low.array() - margin <= other.high.array()).all() && (other.low.array() - margin <= high.array()).all();
  }
};

class BoxTree {
 public:
  /// One leaf per box, split at the median of the longest axis.
  void build(std::vector<Box> boxes);
  /// Updates the tree for moved boxes; `boxes` has the shape passed to build().
  void refit(const std::vector<Box>& boxes);
  bool empty() const { return nodes_.empty(); }
  const Box& whole() const { return nodes_.front().box; }

  /// visit(i) for every box i that intersects `box`.
  template <class Visit>
  void forEachMeeting(const Box& box, Visit&& visit) const {
    if (empty()) return;
    Stack waiting{0};
    for (std::size_t count = 1; count > 0;) {
      const Node& node = nodes_[std::size_t(waiting[--count])];
      if (!node.box.meets(box)) continue;
      if (node.item >= 0) {
        visit(node.item);
      } else {
        waiting[count++] = node.right;
        waiting[count++] = node.left;
      }
    }
  }
  /// visit(i, distance) for the boxes by ascending distance from p, as long as it returns true.
  template <class Visit>
  void forEachByDistance(const Vec3& p, Visit&& visit) const {
    std::vector<std::pair<double, Index>> heap;  // of nodes
    const auto add = [&](Index node) {
      heap.emplace_back(nodes_[std::size_t(node)].box.distanceTo(p), node);
      std::push_heap(heap.begin(), heap.end(), std::greater<>());
    };
    if (!empty()) add(0);
    while (!heap.empty()) {
      std::pop_heap(heap.begin(), heap.end(), std::greater<>());
      const double distance = heap.back().first;
      const Node& node = nodes_[std::size_t(heap.back().second)];
      heap.pop_back();
      if (node.item < 0)
        add(node.left), add(node.right);
      else if (!visit(node.item, distance))
        return;
    }
  }
  /// visit(i, j) for each box i of this tree and j of `other` that are nearer than `margin` along every axis; each pair once
  /// if `other` is this tree.
  template <class Visit>
  void forEachPair(const BoxTree& other, double margin, Visit&& visit) const {
    if (!empty() && !other.empty()) descend(0, other, 0, margin, visit);
  }

 private:
  /// A parent comes before its children.
  struct Node {
    Box box;
    Index left = -1, right = -1, item = -1;
    Index items = 1;  ///< below
  };
  using Stack = std::array<Index, 66>;  ///< trees are no deeper than the bits of a number of boxes
  template <class Visit>
  void descend(Index i, const BoxTree& other, Index j, double margin, Visit& visit) const {
    const Node &p = nodes_[std::size_t(i)], &q = other.nodes_[std::size_t(j)];
    if (this == &other && i == j) {
      if (p.item >= 0) return;
      descend(p.left, other, p.left, margin, visit);
      descend(p.right, other, p.right, margin, visit);
      descend(p.left, other, p.right, margin, visit);
    } else if (!p.box.isNear(q.box, margin)) {
      return;
    } else if (p.item >= 0 && q.item >= 0) {
      visit(p.item, q.item);
    } else if (p.items >= q.items) {
      descend(p.left, other, j, margin, visit);
      descend(p.right, other, j, margin, visit);
    } else {
      descend(i, other, q.left, margin, visit);
      descend(i, other, q.right, margin, visit);
    }
  }
  Index makeNode(const std::vector<Box>& boxes, std::vector<Index>& order, std::size_t begin, std::size_t end);

  std::vector<Node> nodes_;
};

}  // namespace stroma
