// SPDX-License-Identifier: LGPL-2.1-or-later
// How StaticSolver finds the equilibrium at the end of a step.
//
// A step whose loads or prescribed motion are too large for a single solve is divided. With the unbalanced force f0 = f(x0) at
// the start of the step and the fraction s of the step, a part solves
//
//   f(x) - (1 - s) f0 = 0,   prescribed nodes where they are at t + s dt
//
// and s grows to 1. A part that fails is made 4 times smaller, and after a success the next one is twice as large; at s = 0 the
// start is in balance under any load. Parts end at a relative residual of 1e-4, the last one at the tolerance of the step. No part is
// smaller than `smallest_part`: the step is then tried once more as a whole, from its start, with all iterations that the scene
// allows. Other solves are abandoned if |R| has not halved in ten iterations. This is too early for a slack thread of stiff springs, which
// first slides down a valley of its energy while |R| rises and falls; and each part would start where the valley begins.
//
// A solve that fails or stagnates with the approximate tangent of a force field (tangent="warped") is repeated with the exact one,
// from the best iterate and then from its start. A solve that reduces |R| by less than a factor of 10 per iteration, with more than
// six such iterations to come, uses it too if it is symmetric (method svd). If that helped, later steps start with it. The linear
// solver must support it: CGLinearSolver supports symmetric ones only. With fewer than five Newton iterations it is not tried.
//
// With Lagrangian constraints, including ConstraintContact, f(x) + J^T l = 0 and their conditions are solved together
// (conditions_newton.h). A step that fails, or inverts elements, is divided if nodes, a length or a volume move in it
// (conditioned_statics.h). A solve that fails with the approximate tangent is repeated once with the exact one, from the start of the step.
#pragma once
#include "components/integrators/conditioned_statics.h"
#include "components/integrators/equilibrium.h"
#include "components/integrators/exact_tangent.h"
#include "components/integrators/newton.h"

namespace stroma {

class StaticStep {
 public:
  Newton newton;
  Equilibrium problem;
  ConditionedStatics conditioned;
  ExactTangent exact;

  /// `settings` and `smallest_part` are read in each step.
  StaticStep(const NewtonSettings& settings, const double& smallest_part) : settings_(settings), smallest_part_(smallest_part) {}
  void compile(System& system, LinearSolver& solver);
  /// Starts from the present x, after Equilibrium::begin(). Without convergence the report says why, and x is the last equilibrium or the
  /// best iterate.
  StepReport solve(const StepContext& context);
  /// With fewer iterations the scene does not ask for an equilibrium, and nothing further is tried.
  bool triesMore() const { return settings_.iterations >= 5 && !settings_.stop_when_residual_grows; }
  bool mayDivide() const { return smallest_part_ < 1 && triesMore(); }

 private:
  bool hasConditions() const { return !conditioned.empty() && !is_free_; }
  Rows x() const { return system_->independent(system_->x); }
  StepReport solvePart(const StepContext& context);
  StepReport solveWithFallback(const StepContext& context);
  StepReport solveForces(const StepContext& context);
  StepReport solveConditions(const StepContext& context);
  bool solvePatiently(const StepContext& context, StepReport& report);
  bool advancePrescribed(const StepContext& context, StepReport& report);
  bool carryAlong(ConstRows prescribed, bool is_solved);

  const NewtonSettings& settings_;
  const double& smallest_part_;
  System* system_ = nullptr;
  LinearSolver* solver_ = nullptr;
  Vector force_, good_;                         ///< of the free rows; x at the start of a part
  Vector mode_, moved_, moved_v_, displacement_;  ///< work space of advancePrescribed(), shape (all rows)
  bool is_free_ = false;  ///< the step ignores Lagrangian constraints
};

}  // namespace stroma
