// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

namespace stroma {

/// A component whose forces depend on more of the past than x and v: viscous stresses, fluid pressures. What it
/// remembers is state, as x and v are. Forces are evaluated any number of times in a step (Newton iterations, line
/// searches, stages) and must not change it; it moves on once, in stepEnded(). A step that is taken back therefore
/// leaves it as it was, and nobody has to roll it back. Component::reset() goes back to the start.
class History {
 public:
  virtual ~History() = default;
  /// The step to time t [s] stands: x and v of the states are its result. Called for every step that is kept, when all
  /// systems have made theirs.
  virtual void stepEnded(double t) = 0;
  /// All that is remembered, in an order that does not depend on the machine: stored, and given to setHistory() of the
  /// same scene with the same x, v and time, it continues the run.
  virtual const std::vector<double>& history() const = 0;
  /// Throws std::invalid_argument when the number of values is another.
  virtual void setHistory(const std::vector<double>& values) = 0;
};

}  // namespace stroma
