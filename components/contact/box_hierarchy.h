// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <limits>
#include <vector>

#include "framework/scene/types.h"

namespace stroma::contact {

/// A box along the axes; empty until a point is added.
struct Box {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  void add(const Vec3& p) { low = low.cwiseMin(p), high = high.cwiseMax(p); }
  void add(const Box& other) { low = low.cwiseMin(other.low), high = high.cwiseMax(other.high); }
  /// Nearer than `margin` in every direction of the axes.
  bool meets(const Box& o, double margin) const {
    return (low.array() - margin <= o.high.array()).all() && (high.array() + margin >= o.low.array()).all();
  }
};

/// A binary tree of boxes over items that have one each. Its shape is made once, by the halves along the longest side of
/// the items' middles; when they move, the boxes follow in place.
class Hierarchy {
 public:
  void build(const std::vector<Box>& items);
  void refit(const std::vector<Box>& items);
  /// visit(i, j) for each item i of `a` and j of `b` whose boxes meet. With a == b: each pair of two items once.
  template <class Visit>
  static void pairs(const Hierarchy& a, const Hierarchy& b, double margin, Visit&& visit) {
    if (a.nodes_.empty() || b.nodes_.empty()) return;
    descend(a, 0, b, 0, margin, visit);
  }

 private:
  static constexpr int leaf_size = 4;
  struct Node {
    Box box;
    int first = 0, count = 0;  ///< of order_; the left child is the next node
    int right = -1;            ///< -1: a leaf
  };
  int split(const std::vector<Box>& items, int first, int count);
  void fit(Node& node, int index) const;

  template <class Visit>
  static void descend(const Hierarchy& a, int i, const Hierarchy& b, int j, double margin, Visit&& visit) {
    const Node &p = a.nodes_[std::size_t(i)], &q = b.nodes_[std::size_t(j)];
    const bool same = &a == &b && i == j;
    if (!same && !p.box.meets(q.box, margin)) return;
    if (p.right < 0 && q.right < 0) {
      for (int k = p.first; k < p.first + p.count; ++k)
        for (int l = same ? k + 1 : q.first; l < q.first + q.count; ++l)
          if (a.boxes_[std::size_t(k)].meets(b.boxes_[std::size_t(l)], margin))
            visit(a.order_[std::size_t(k)], b.order_[std::size_t(l)]);
      return;
    }
    if (same) {
      descend(a, i + 1, b, i + 1, margin, visit);
      descend(a, p.right, b, p.right, margin, visit);
      descend(a, i + 1, b, p.right, margin, visit);
    } else if (q.right < 0 || (p.right >= 0 && p.count >= q.count)) {
      descend(a, i + 1, b, j, margin, visit);
      descend(a, p.right, b, j, margin, visit);
    } else {
      descend(a, i, b, j + 1, margin, visit);
      descend(a, i, b, q.right, margin, visit);
    }
  }

  std::vector<Node> nodes_;  ///< parents before children
  std::vector<int> order_;   ///< items as the leaves have them
  std::vector<Box> boxes_;   ///< in that order
};

}  // namespace stroma::contact
