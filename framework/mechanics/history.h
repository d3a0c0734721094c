// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

namespace stroma {

/// A component with internal state besides x and v: viscous stresses, fluid pressures. Forces are evaluated any number of
/// times in a step (Newton iterations, line searches, stages) and must not change this state. It advances once, in
/// stepEnded(), so a rejected step needs no rollback. Component::reset() restores the start; Component::serialize()
/// stores the state.
class History {
 public:
  virtual ~History() = default;
  /// The step to time t [s] is accepted, and x and v of the states are its result. Called once per accepted step, after all
  /// systems have made theirs.
  virtual void stepEnded(double t) = 0;
  /// Empty, or why the completed step is no valid result although all its equations were solved. Called in statics only:
  /// with inertia bodies may oscillate, and integrators detect when they do so too fast.
  virtual std::string fault() const { return {}; }
  /// The internal state, for output.
  virtual const std::vector<double>& history() const = 0;
};

}  // namespace stroma
