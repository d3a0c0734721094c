// SPDX-License-Identifier: LGPL-2.1-or-later
// How StaticSolver finds the equilibrium at the end of a step.
//
// A step whose loads or whose prescribed motion are too much for one go is divided. With f0 = f(x0) the forces out of
// balance where the step starts and s the share of the step, a part solves
//
//   f(x) - (1 - s) f0 = 0,   prescribed nodes where they are at t + s dt
//
// and s grows to 1 by parts that become smaller by 4 where one fails and larger by 2 after each that does not: at s = 0 the
// start is in balance whatever acts on it. Parts end at a relative residual of 1e-4, the last one at the step's own. No part is
// smaller than `smallest_part`: then the step is tried once more in one go, from its start, for as many iterations as the scene
// allows. Solves end before that where |R| has not halved in ten iterations, but what hangs as a slack thread of stiff springs first
// slides down a valley of its energy, in which |R| rises and falls; and parts of the step begin where the valley begins.
//
// A solve that fails or gets no further with the approximate tangent of a force field (tangent="warped") is tried
// with the exact one, from the best iterate and then from where it began. One that gets on by a factor above 0.1, with more than
// six such still to go, takes it too, where it is symmetric (method svd). Where that helped, later steps begin with it. The linear
// solver must take it: CGLinearSolver takes symmetric ones only. With fewer than five Newton iterations it is not tried.
//
// With Lagrangian constraints, contact by ConstraintContact among them, f(x) + J^T l = 0 and their conditions are solved together
// (conditions_newton.h). A step that fails is divided where nodes or a volume move in it (conditioned_statics.h). What fails with the
// approximate tangent is tried once with the exact one, from where the step began. Slides and ways are those of the step.
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
  /// From the present x, where Equilibrium::begin() was called. A step that has not converged says why and leaves its last equilibrium,
  /// or the best iterate.
  StepReport solve(const StepContext& context);
  /// With fewer iterations the scene does not ask for an equilibrium.
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
  Vector force_, good_;                         ///< of the free rows; the x where a part starts
  Vector mode_, moved_, moved_v_, displacement_;  ///< work space of advancePrescribed(), shape (all rows)
  bool is_free_ = false;  ///< the step is made as if there were no Lagrangian constraints
};

}  // namespace stroma
