// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "framework/simulation/constraint_set.h"

namespace stroma {

class Integrator;

/// The position constraints of a system: corrections of x and v after the integrator's step.
class PositionCorrections {
 public:
  /// Allocates; throws ComponentError if the integrator or a state does not support position constraints.
  void compile(const Actors& actors, const Integrator& integrator, ConstraintSet& constraints);
  bool empty() const { return !actors_ || actors_->position_constraints.empty(); }
  /// Corrects x and v, shape (all rows), at the end of a step from positions `x_start`. Mapped rows are not updated.
  void enforce(const StepContext& context, ConstRows x_start, Rows x, Rows v, StepReport& report);

 private:
  const Actors* actors_ = nullptr;
  const ConstraintSet* constraints_ = nullptr;
  Mobility mobility_;
  Vector reference_;  ///< positions that velocities refer to, shape (independent rows), only with position constraints
  Vector before_;     ///< positions before a sweep of the constraints
};

}  // namespace stroma
