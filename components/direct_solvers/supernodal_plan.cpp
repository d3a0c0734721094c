// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/direct_solvers/supernodal_plan.h"

#include <algorithm>
#include <queue>

namespace stroma {
namespace {

/// No part has more of the flops than one in so many: a few parts for each thread of a machine of today.
constexpr double parts_wanted = 64;

/// Divides a tree whose supernodes take `work` into parts.
class Divider {
 public:
  Divider(const std::vector<int>& parent, const std::vector<double>& work) : children_(parent.size()) {
    std::vector<double> whole = work;
    for (std::size_t s = 0; s < parent.size(); ++s) {  // children before parents
      all_ += work[s];
      if (parent[s] < 0) {
        trees_.emplace(whole[s], int(s));
        continue;
      }
      children_[std::size_t(parent[s])].push_back(int(s));
      whole[std::size_t(parent[s])] += whole[s];
    }
    while (!trees_.empty() && trees_.top().first > all_ / parts_wanted && !children_[std::size_t(trees_.top().second)].empty()) {
      const int root = trees_.top().second;
      trees_.pop();
      tree_.top.push_back(root);
      for (const int child : children_[std::size_t(root)]) trees_.emplace(whole[std::size_t(child)], child);
    }
    std::sort(tree_.top.begin(), tree_.top.end());
  }

  /// Subtrees as parts, the largest first; small ones together.
  TreeParts gather() {
    double room = 0;
    std::vector<int> stack;
    while (!trees_.empty()) {
      const auto [work, root] = trees_.top();
      trees_.pop();
      if (room <= 0) tree_.parts.emplace_back(), room = all_ / (2 * parts_wanted);
      room -= work;
      stack.assign(1, root);
      while (!stack.empty()) {
        const int s = stack.back();
        stack.pop_back();
        tree_.parts.back().push_back(s);
        const auto& below = children_[std::size_t(s)];
        stack.insert(stack.end(), below.begin(), below.end());
      }
    }
    for (std::vector<int>& part : tree_.parts) std::sort(part.begin(), part.end());
    return std::move(tree_);
  }

 private:
  std::vector<std::vector<int>> children_;
  std::priority_queue<std::pair<double, int>> trees_;  ///< the work of a subtree, its root
  double all_ = 0;
  TreeParts tree_;
};

class Planner {
 public:
  explicit Planner(const SupernodalPattern& pattern)
      : pattern_(pattern), supernode_(std::size_t(pattern.columns)), work_(std::size_t(pattern.count), 0.0) {
    for (int s = 0; s < pattern.count; ++s)
      std::fill(supernode_.begin() + pattern.first[s], supernode_.begin() + pattern.first[s + 1], s);
  }

  /// The loop of the factorisation, without its numbers. Supernodes that still have to act wait in the list of the next
  /// one that they act on.
  void listUpdates(SupernodalPlan& plan) {
    const std::size_t count = std::size_t(pattern_.count);
    std::vector<int> list(count, -1), next(count), done(count);
    const auto waitFor = [&](int d, int rows_done) {
      done[std::size_t(d)] = rows_done;
      if (rows_done == pattern_.heightOf(d)) return;
      int& head = list[std::size_t(supernode_[std::size_t(pattern_.rowsOf(d)[rows_done])])];
      next[std::size_t(d)] = head;
      head = d;
    };
    plan.update_start.assign(1, 0);
    for (int s = 0; s < pattern_.count; ++s) {
      for (int d = list[std::size_t(s)], following = -1; d >= 0; d = following) {
        following = next[std::size_t(d)];
        const int height = pattern_.heightOf(d), from = done[std::size_t(d)], *rows = pattern_.rowsOf(d);
        const int wide = int(std::lower_bound(rows + from, rows + height, pattern_.first[s + 1]) - rows) - from;
        plan.updates.push_back({d, from, wide});
        work_[std::size_t(s)] += double(wide) * (2.0 * (height - from) - wide) * pattern_.columnsOf(d);
        waitFor(d, from + wide);
      }
      plan.update_start.push_back(int(plan.updates.size()));
      const double columns = pattern_.columnsOf(s), below = pattern_.heightOf(s) - columns;
      work_[std::size_t(s)] += columns * columns * (columns / 3 + below);
      waitFor(s, int(columns));
    }
    for (const double work : work_) plan.flops += work;
  }

  void divide(SupernodalPlan& plan) {
    std::vector<int> parent;
    for (int s = 0; s < pattern_.count; ++s) {
      const int columns = pattern_.columnsOf(s);
      const bool is_root = columns == pattern_.heightOf(s);
      parent.push_back(is_root ? -1 : supernode_[std::size_t(pattern_.rowsOf(s)[columns])]);
    }
    plan.tree = divideTree(parent, work_);
  }

 private:
  const SupernodalPattern& pattern_;
  std::vector<int> supernode_;  ///< of a column
  std::vector<double> work_;    ///< flops of a supernode: what acts on it, and itself
};

}  // namespace

TreeParts divideTree(const std::vector<int>& parent, const std::vector<double>& work) { return Divider(parent, work).gather(); }

SupernodalPlan planOf(const SupernodalPattern& pattern) {
  SupernodalPlan plan;
  Planner planner(pattern);
  planner.listUpdates(plan);
  planner.divide(plan);
  return plan;
}

}  // namespace stroma
