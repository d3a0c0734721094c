// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/direct_solvers/front_plan.h"

#include <algorithm>
#include <map>
#include <numeric>


namespace stroma {
namespace {

/// Factors of fewer operations are made by one thread.
constexpr double alone_operations = 1e8;

/// Memory that is given back in any order, as offsets: the first gap that is wide enough.
class Offsets {
 public:
  std::size_t take(std::size_t count) {
    for (auto gap = gaps_.begin(); gap != gaps_.end(); ++gap) {
      const auto [at, size] = *gap;
      if (size < count) continue;
      gaps_.erase(gap);
      if (size > count) gaps_.emplace(at + count, size - count);
      return at;
    }
    std::size_t at = size_;
    if (!gaps_.empty() && gaps_.rbegin()->first + gaps_.rbegin()->second == size_) {
      at = gaps_.rbegin()->first;
      gaps_.erase(at);
    }
    size_ = at + count;
    return at;
  }
  void giveBack(std::size_t at, std::size_t count) {
    if (count == 0) return;
    auto gap = gaps_.emplace(at, count).first;
    if (const auto next = std::next(gap); next != gaps_.end() && at + count == next->first) {
      gap->second += next->second;
      gaps_.erase(next);
    }
    if (gap == gaps_.begin()) return;
    const auto before = std::prev(gap);
    if (before->first + before->second != gap->first) return;
    before->second += gap->second;
    gaps_.erase(gap);
  }
  std::size_t size() const { return size_; }

 private:
  std::map<std::size_t, std::size_t> gaps_;
  std::size_t size_ = 0;
};

class Builder {
 public:
  explicit Builder(const SupernodalPattern& pattern) : pattern_(pattern), count_(std::size_t(pattern.count)) {}

  FrontPlan build(const int* lower_start, const int* lower_rows) {
    layOut();
    listChildren();
    listRuns();
    listEntries(lower_start, lower_rows);
    placeUpdates();
    return std::move(plan_);
  }

 private:
  int below(int s) const { return pattern_.heightOf(s) - pattern_.columnsOf(s); }
  std::size_t updateSize(int s) const { return std::size_t(FrontPlan::padded(below(s))) * std::size_t(below(s)); }

  void layOut() {
    supernode_.resize(std::size_t(pattern_.columns));
    plan_.values.assign(1, 0), plan_.vector.assign(1, 0);
    for (int s = 0; s < pattern_.count; ++s) {
      std::fill(supernode_.begin() + pattern_.first[s], supernode_.begin() + pattern_.first[s + 1], s);
      const int columns = pattern_.columnsOf(s);
      const std::size_t column = std::size_t(FrontPlan::padded(columns) + FrontPlan::padded(below(s)));
      plan_.values.push_back(plan_.values.back() + column * std::size_t(columns));
      plan_.vector.push_back(plan_.vector.back() + column);
    }
  }

  void listChildren() {
    std::vector<double> work;
    plan_.child_start.assign(count_ + 1, 0);
    for (int s = 0; s < pattern_.count; ++s) {
      const double columns = pattern_.columnsOf(s), rows = below(s);
      const int parent = rows > 0 ? supernode_[std::size_t(pattern_.rowsOf(s)[pattern_.columnsOf(s)])] : -1;
      plan_.parent.push_back(parent);
      if (parent >= 0) ++plan_.child_start[std::size_t(parent) + 1];
      work.push_back(columns * (columns * (columns / 3 + rows) + rows * rows));
    }
    plan_.flops = std::accumulate(work.begin(), work.end(), 0.0);
    std::partial_sum(plan_.child_start.begin(), plan_.child_start.end(), plan_.child_start.begin());
    plan_.children.resize(std::size_t(plan_.child_start.back()));
    std::vector<int> next(plan_.child_start.begin(), plan_.child_start.end() - 1);
    for (int s = 0; s < pattern_.count; ++s)
      if (plan_.parent[std::size_t(s)] >= 0) plan_.children[std::size_t(next[std::size_t(plan_.parent[std::size_t(s)])]++)] = s;
    if (plan_.flops > alone_operations) {
      plan_.tree = divideTree(plan_.parent, work);
    } else {
      plan_.tree.parts.emplace_back(count_);
      std::iota(plan_.tree.parts[0].begin(), plan_.tree.parts[0].end(), 0);
    }
  }

  void listRuns() {
    std::vector<int> place(std::size_t(pattern_.columns));
    plan_.run_start.assign(count_ + 1, 0);
    std::vector<std::vector<FrontRun>> runs(count_);
    for (int parent = 0; parent < pattern_.count; ++parent) {
      const int columns = pattern_.columnsOf(parent);
      for (int i = 0; i < pattern_.heightOf(parent); ++i) place[std::size_t(pattern_.rowsOf(parent)[i])] = i;
      for (int k = plan_.child_start[std::size_t(parent)]; k < plan_.child_start[std::size_t(parent) + 1]; ++k) {
        const int child = plan_.children[std::size_t(k)];
        const int* rows = pattern_.rowsOf(child) + pattern_.columnsOf(child);
        std::vector<FrontRun>& list = runs[std::size_t(child)];
        for (int i = 0; i < below(child); ++i) {
          const int to = place[std::size_t(rows[i])];
          if (!list.empty() && to == list.back().to + list.back().count && to != columns)
            ++list.back().count;
          else
            list.push_back({i, to, 1});
        }
      }
    }
    for (std::size_t s = 0; s < count_; ++s) {
      plan_.runs.insert(plan_.runs.end(), runs[s].begin(), runs[s].end());
      plan_.run_start[s + 1] = int(plan_.runs.size());
    }
  }

  void listEntries(const int* start, const int* rows) {
    plan_.entry.reserve(std::size_t(start[pattern_.columns]));
    for (int s = 0; s < pattern_.count; ++s) {
      const int columns = pattern_.columnsOf(s), triangle = FrontPlan::padded(columns), rest = FrontPlan::padded(below(s));
      const int* own = pattern_.rowsOf(s);
      for (int k = 0; k < columns; ++k)
        for (int p = start[pattern_.first[s] + k]; p < start[pattern_.first[s] + k + 1]; ++p) {
          const int i = int(std::lower_bound(own, own + pattern_.heightOf(s), rows[p]) - own);
          plan_.entry.push_back(i < columns ? k * triangle + i : columns * triangle + k * rest + i - columns);
        }
    }
  }

  /// In the order of the work: parts at any time, each alone, and then the rest.
  void placeUpdates() {
    plan_.update.resize(count_), plan_.shared.assign(count_, 1);
    Offsets shared;
    for (const std::vector<int>& part : plan_.tree.parts) {
      Offsets own;
      for (const int s : part) plan_.shared[std::size_t(s)] = 0;
      for (const int s : part)  // the roots of parts
        if (const int up = plan_.parent[std::size_t(s)]; up >= 0 && plan_.shared[std::size_t(up)]) plan_.shared[std::size_t(s)] = 2;
      for (const int s : part) place(s, plan_.shared[std::size_t(s)] ? shared : own, own);
      for (const int s : part)
        if (plan_.shared[std::size_t(s)] == 2) plan_.shared[std::size_t(s)] = 1;
      plan_.part_size = std::max(plan_.part_size, own.size());
    }
    for (const int s : plan_.tree.top) place(s, shared, shared);
    plan_.shared_size = shared.size();
  }
  void place(int s, Offsets& to, Offsets& from) {
    plan_.update[std::size_t(s)] = to.take(updateSize(s));
    for (int k = plan_.child_start[std::size_t(s)]; k < plan_.child_start[std::size_t(s) + 1]; ++k) {
      const int child = plan_.children[std::size_t(k)];
      from.giveBack(plan_.update[std::size_t(child)], updateSize(child));
    }
  }

  const SupernodalPattern& pattern_;
  std::size_t count_;
  std::vector<int> supernode_;  ///< of a column
  FrontPlan plan_;
};

}  // namespace

int FrontPlan::padded(int rows) { return (rows + front_rows - 1) / front_rows * front_rows; }

FrontPlan frontPlanOf(const SupernodalPattern& pattern, const int* lower_start, const int* lower_rows) {
  return Builder(pattern).build(lower_start, lower_rows);
}

}  // namespace stroma
