// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/direct_solvers/supernodal_plan.h"

#include <algorithm>
#include <queue>

namespace stroma {
namespace {

/// No part has more of the flops than one in so many: a few parts for each thread of a machine of today.
constexpr double parts_wanted = 64;

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
    const std::size_t count = std::size_t(pattern_.count);
    std::vector<std::vector<int>> children(count);
    std::vector<double> whole = work_;
    std::priority_queue<std::pair<double, int>> trees;
    for (int s = 0; s < pattern_.count; ++s) {  // children before parents
      const int columns = pattern_.columnsOf(s);
      if (columns == pattern_.heightOf(s)) {
        trees.emplace(whole[std::size_t(s)], s);
        continue;
      }
      const int parent = supernode_[std::size_t(pattern_.rowsOf(s)[columns])];
      children[std::size_t(parent)].push_back(s);
      whole[std::size_t(parent)] += whole[std::size_t(s)];
    }
    while (!trees.empty() && trees.top().first > plan.flops / parts_wanted &&
           !children[std::size_t(trees.top().second)].empty()) {
      const int root = trees.top().second;
      trees.pop();
      plan.top.push_back(root);
      for (const int child : children[std::size_t(root)]) trees.emplace(whole[std::size_t(child)], child);
    }
    std::sort(plan.top.begin(), plan.top.end());
    gather(trees, children, plan);
  }

 private:
  /// Subtrees as parts, the largest first; small ones together.
  void gather(std::priority_queue<std::pair<double, int>>& trees, const std::vector<std::vector<int>>& children,
              SupernodalPlan& plan) const {
    double room = 0;
    std::vector<int> stack;
    while (!trees.empty()) {
      const auto [work, root] = trees.top();
      trees.pop();
      if (room <= 0) plan.parts.emplace_back(), room = plan.flops / (2 * parts_wanted);
      room -= work;
      stack.assign(1, root);
      while (!stack.empty()) {
        const int s = stack.back();
        stack.pop_back();
        plan.parts.back().push_back(s);
        const auto& below = children[std::size_t(s)];
        stack.insert(stack.end(), below.begin(), below.end());
      }
    }
    for (std::vector<int>& part : plan.parts) std::sort(part.begin(), part.end());
  }

  const SupernodalPattern& pattern_;
  std::vector<int> supernode_;  ///< of a column
  std::vector<double> work_;    ///< flops of a supernode: what acts on it, and itself
};

}  // namespace

SupernodalPlan planOf(const SupernodalPattern& pattern) {
  SupernodalPlan plan;
  Planner planner(pattern);
  planner.listUpdates(plan);
  planner.divide(plan);
  return plan;
}

}  // namespace stroma
