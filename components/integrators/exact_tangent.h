// SPDX-License-Identifier: LGPL-2.1-or-later
// Where Newton's method fails with an approximate tangent (rotations held fixed in the derivative), the derivative of
// the force itself may converge: a solve is then made again with it.
#pragma once
#include "framework/algebra/linear_solver.h"
#include "framework/mechanics/open_choices.h"
#include "framework/simulation/system.h"

namespace stroma {

/// Switches the force fields of a system from their approximate tangent to the exact one, for the rest of a solve. The
/// force stays what it is. Takes effect with the next force that is computed.
class ExactTangent {
 public:
  /// False, and nothing has changed, where no field has another tangent or the linear solver cannot take the exact one.
  bool begin(System& system) {
    if (system_) return false;
    bool changed = false;
    for (ForceField* field : system.forceFields())
      if (!field->traits().exact_tangent && switchOf(field, true)) changed = true;
    if (!changed) return false;
    system_ = &system;
    if (!system.linearSolver()->needsSymmetric() || system.matrix().symmetric()) return true;
    end();
    return false;
  }
  void end() {
    if (!system_) return;
    for (ForceField* field : system_->forceFields()) switchOf(field, false);
    system_ = nullptr;
  }
  bool isOn() const { return system_ != nullptr; }

 private:
  static bool switchOf(ForceField* field, bool exact) {
    auto* open = dynamic_cast<OpenChoices*>(field);
    return open && open->useExactTangent(exact);
  }
  System* system_ = nullptr;
};

inline void declareExactTangentSteps(DataTable& table, int& steps) {
  table.add("exactTangentSteps", steps)
      .help("how many steps so far failed with an approximate tangent of a force field and went on with the exact one")
      .unit("-")
      .output();
}

/// Adds the work of another solve of the same step.
inline void addCounts(const StepReport& from, StepReport& to) {
  to.newton_iterations += from.newton_iterations;
  to.linear_iterations += from.linear_iterations;
  to.factorisations += from.factorisations;
  to.solve_seconds += from.solve_seconds;
}

}  // namespace stroma
