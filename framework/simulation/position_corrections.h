// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "framework/simulation/constraint_set.h"

namespace stroma {

class Integrator;

/// The position constraints of a system: corrections of x and v after the integrator's step.
class PositionCorrections {
 public:
  /// Allocates; throws ComponentError where the integrator or a state does not bear position constraints.
  void compile(const Actors& actors, const Integrator& integrator, ConstraintSet& constraints);
  bool empty() const { return !actors_ || actors_->position_constraints.empty(); }
  /// Corrects x and v, shape (all rows), at the end of a step from positions `x_start`. Mapped rows are left behind.
  void enforce(const StepContext& context, ConstRows x_start, Rows x, Rows v, StepReport& report);

 private:
  const Actors* actors_ = nullptr;
  const ConstraintSet* constraints_ = nullptr;
  Mobility mobility_;
  Vector reference_;  ///< where velocities are taken from, shape (independent rows), only with position constraints
  Vector before_;     ///< what a turn of the constraints started from
};

}  // namespace stroma
