// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "framework/mechanics/step_limiter.h"
#include "framework/simulation/system.h"

namespace stroma {

/// Those of a system's force fields that limit its steps. Without any, nothing is done.
class StepLimits {
 public:
  void compile(System& system);
  bool empty() const { return limiters_.empty(); }
  /// The largest s <= 1 up to which the system's positions may move by s * factor * dx; dx has the independent rows.
  double longest(ConstRows dx, double factor = 1);
  /// Something that was held fixed in the solve that has ended has moved on: it is to be made again.
  bool moveOn();

 private:
  System* system_ = nullptr;
  std::vector<StepLimiter*> limiters_;
  Vector scaled_;  ///< shape (independentRows()), only with limiters
};

// ---- told by the system and the simulation ----
void beginLimitedStep(const System& system, ConstRows x, double t, double t_end);
/// What lies in one another after a step, or empty.
std::string overlapIn(System& system);
/// Throws ComponentError when an integrator does not ask how far it may step, or something else moves positions too.
void checkStepLimits(const System& system);

}  // namespace stroma
