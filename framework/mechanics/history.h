// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

namespace stroma {

/// A component whose forces depend on more of the past than x and v: viscous stresses, fluid pressures. What it
/// remembers is state, as x and v are. Forces are evaluated any number of times in a step (Newton iterations, line
/// searches, stages) and must not change it; it moves on once, in stepEnded(). A step that is taken back therefore
/// leaves it as it was, and nobody has to roll it back. Component::reset() goes back to the start;
/// Component::serialize() stores it.
class History {
 public:
  virtual ~History() = default;
  /// The step to time t [s] stands: x and v of the states are its result. Called for every step that is kept, when all
  /// systems have made theirs.
  virtual void stepEnded(double t) = 0;
  /// Empty, or a sentence: why the step that has ended is no result, although every equation of it was solved. Asked in
  /// statics only: with inertia bodies may swing, and integrators know when they do so too fast.
  virtual std::string fault() const { return {}; }
  /// What is remembered, to look at.
  virtual const std::vector<double>& history() const = 0;
};

}  // namespace stroma
