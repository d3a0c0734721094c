// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>

#include "components/integrators/conditions_newton.h"
#include "framework/simulation/system.h"

namespace stroma {

/// Equilibrium with forces of constraint, f(x) + J^T l = 0 in the free directions, and the conditions of Lagrangian constraints.
/// The unknown u is the way since the step began: x = x0 + u, where rows that turn do so by the rotation vector in u.
class ConditionedStatics final : public NonlinearProblem {
 public:
  /// Throws ComponentError where something bounds steps that this does not ask.
  void compile(System& system);
  /// No Lagrangian constraint is there.
  bool empty() const { return multipliers_.empty(); }
  /// A step from the present x, in one go: conditions are of its end. `advance` moves x where motion is prescribed, and is false when
  /// that is there; `retry` changes the tangent after a solve that failed, or is false.
  StepReport solve(Newton& newton, LinearSolver& solver, StopToken stop, const std::function<bool(StepReport&)>& advance,
                   const std::function<bool()>& retry);
  /// J^T l of the step before [N].
  void addCarried(Rows out) const { multipliers_.addCarried(out); }
  void stepTaken() { multipliers_.stepTaken(); }
  void reset() { multipliers_.reset(); }
  void serialize(Archive& archive) { multipliers_.serialize(archive); }

  // ---- as equations for Newton's method ----
  void residual(Rows out) override;
  SystemMatrix& tangent() override { return system_->matrix().withFactors({.stiffness = -1}); }
  double energy() override { return 0; }  // not asked for
  Rows unknowns() override { return way_; }
  void unknownsChanged() override;
  double displacementPerUnknown() const override { return 1; }
  ConstRows positions() const override { return x(); }
  double travelled() const override { return norm(way_); }
  double loadScale() const override { return norm(system_->f); }
  RoundOff roundOff() override { return {}; }

 private:
  Rows x() const { return system_->independent(system_->x); }
  System* system_ = nullptr;
  Multipliers multipliers_;
  ConditionsNewton conditions_;
  Vector start_, way_;  ///< x0 and u
  Vector load_;         ///< J^T l
};

}  // namespace stroma
