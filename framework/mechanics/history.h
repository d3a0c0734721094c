// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

namespace stroma {

/// A component whose forces depend on more of the past than x and v: viscous stresses, fluid pressures. Its history
/// is state, as x and v are. Forces are evaluated any number of times in a step (Newton iterations, line
/// searches, stages) and must not change it; it is updated once, in stepEnded(). A rejected step therefore
/// leaves it as it was, and needs no rollback. Component::reset() goes back to the start;
/// Component::serialize() stores it.
class History {
 public:
  virtual ~History() = default;
  /// The step to time t [s] stands: x and v of the states are its result. Called for every step that is kept, when all
  /// systems have made theirs.
  virtual void stepEnded(double t) = 0;
  /// Empty, or a sentence: why the last step is not a valid result although all its equations were solved. Asked in
  /// statics only: with inertia bodies may oscillate, and integrators detect when they do so too fast.
  virtual std::string fault() const { return {}; }
  /// The history, read only.
  virtual const std::vector<double>& history() const = 0;
};

}  // namespace stroma
