// SPDX-License-Identifier: LGPL-2.1-or-later
// The cheapest configuration with an error below a bound, without the whole grid. Assumed along each axis that has an order
// (mesh, time step, tolerance, iterations), the other values being the same: a finer value has no larger error and takes no
// less time. So a configuration that misses the bound speaks for all coarser ones, and one that keeps it, or takes longer
// than the cheapest so far, for all finer ones. Axes of words are searched in full.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "tools/sweep/axis.h"

namespace stroma::sweep {

/// "error<1%" or "error<0.01". Throws std::invalid_argument with a sentence.
double parseGoal(const std::string& text);

/// What a run has shown.
struct Shown {
  bool has_result = false;
  double error = 0, seconds = 0;
};

class GoalSearch {
 public:
  GoalSearch(const std::vector<Axis>& axes, double bound);
  /// Takes what is known of a configuration, by its choice of values.
  void learn(const std::vector<std::size_t>& choice, const Shown& shown);
  /// The configuration that decides most of those that are open, or empty when none is.
  std::vector<std::size_t> next() const;
  /// The cheapest that keeps the bound, or empty.
  const std::vector<std::size_t>& cheapest() const { return cheapest_; }

 private:
  enum class Fate { open, run, spoken_for };
  /// Whether `a` is at least as fine as `b` on every ordered axis, and has the same words.
  bool isAtLeastAsFine(const std::vector<std::size_t>& a, const std::vector<std::size_t>& b) const;

  const std::vector<Axis>& axes_;
  double bound_;
  std::vector<std::vector<std::size_t>> choices_;
  std::vector<Fate> fates_;
  std::vector<std::size_t> cheapest_;
  double least_seconds_;
  struct Made {
    std::vector<std::size_t> choice;
    double seconds;
  };
  std::vector<Made> made_;
};

}  // namespace stroma::sweep
