// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <fmt/format.h>

#include <functional>

#include "components/integrators/conditions_newton.h"
#include "components/integrators/whole_matrix.h"
#include "components/integrators/exact_tangent.h"
#include "components/integrators/light_bodies.h"
#include "framework/simulation/system.h"

namespace stroma {

/// Nodes that follow others get their positions only after the solve: `advance` and `solve` alternate until the former
/// moves nothing, up to four times.
template <class Advance, class Solve>
StepReport solveWithFollowers(const Advance& advance, const Solve& solve) {
  constexpr int most_solves = 4;
  StepReport report;
  for (int again = 0; report.newton_converged && !report.failed(); ++again) {
    const StepReport before = report;
    StepReport moved;
    if (!advance(moved) && again > 0) break;
    if (!moved.newton_converged || moved.stopped) return moved;
    if (again == most_solves) {
      report.newton_converged = false;
      report.reason = fmt::format("nodes that follow others still moved after {} solves", most_solves);
      break;
    }
    report = solve();
    addCounts(before, report);
    addCounts(moved, report);
  }
  return report;
}

/// Equilibrium with constraint forces, f(x) + J^T l = 0 in the free directions, and the conditions of Lagrangian constraints.
/// The unknown u is the displacement since the start of the step: x = x0 + u, with rotation vectors in u for orientations.
class ConditionedStatics final : public NonlinearProblem {
 public:
  void declare(DataTable& table) { multipliers_.declare(table); }
  /// Throws ComponentError if a step limiter is present that this solve does not support.
  void compile(System& system);
  /// There is no Lagrangian constraint.
  bool empty() const { return multipliers_.empty(); }
  /// At the start of a step: no condition needs a force.
  bool areFree() { return multipliers_.begin(rule, true), multipliers_.areFree(); }
  /// At the end of a step made without them: no condition needs a force, and none is prescribed.
  bool stayFree() { return multipliers_.areFree() && (multipliers_.clearForces(), true); }
  /// Makes a step from the present x as a whole, with the conditions at its end. `advance` moves x to prescribed positions, and returns
  /// false when it is there; `retry` changes the tangent after a failed solve, for another one from the same x, or returns false.
  StepReport solve(Newton& newton, LinearSolver& solver, StopToken stop, const std::function<bool(StepReport&)>& advance,
                   const std::function<bool()>& retry);
  using Advance = std::function<bool(const StepContext&, StepReport&)>;
  /// The same. A step that fails, or inverts elements on its way, is divided if it moves something or changes a length or a volume.
  /// Its parts are at least `smallest` of it, and each starts with the constraint forces of the previous one. Prescribed motion uses
  /// the time of a part, conditions its share (Multipliers::setShare). `advance` goes to the end of a part.
  StepReport solveInParts(Newton& newton, LinearSolver& solver, const StepContext& context, const Advance& advance,
                          const std::function<bool()>& retry, double smallest);
  /// J^T l of the previous step [N].
  void addCarried(Rows out) const { multipliers_.addCarried(out); }
  void stepTaken() { multipliers_.stepTaken(); }
  void reset() { multipliers_.reset(); }
  void serialize(Archive& archive) { multipliers_.serialize(archive), measure_.serialize(archive, "length_with_conditions"); }

  // ---- the equations for Newton's method ----
  void residual(Rows out) override;
  SystemMatrix& tangent() override { return whole_.of(system_->matrix().withFactors({.stiffness = -1})); }
  void projectToFree(Rows d) const override { stroma::projectToFree(*system_, d); }
  double energy() override { return 0; }  // never called
  Rows unknowns() override { return way_; }
  void unknownsChanged() override;
  double displacementPerUnknown() const override { return 1; }
  LightBodies* lightBodies() override { return &bodies_; }
  ConstRows positions() const override { return x(); }
  void updateNorms() override {
    if (system_->motion().turns()) measure_.take(tangent());
  }
  double sizeOf(ConstRows residual) const override { return measure_.force(residual); }
  double lengthOf(ConstRows d) const override { return measure_.way(d); }
  double travelled() const override { return measure_.way(way_); }
  double loadScale() const override { return measure_.force(system_->f); }
  double loads() override { return loadsOn(*system_, measure_, loads_); }
  RoundOff roundOff() override { return {}; }

 private:
  StepReport solveParts(Newton& newton, LinearSolver& solver, const StepContext& context, const Advance& advance,
                        const std::function<bool()>& retry, double smallest, double& done);
  StepReport solveFromStart(Newton& newton, LinearSolver& solver, StopToken stop, const std::function<bool(StepReport&)>& advance);
  Rows x() const { return system_->independent(system_->x); }
  static constexpr Multipliers::Rule rule{.displacement = 1, .weight = 1, .has_velocities = false};
  System* system_ = nullptr;
  WholeIfNeeded whole_;
  ForceMeasure measure_;
  Multipliers multipliers_;
  ConditionsNewton conditions_;
  LightBodies bodies_;
  Vector start_, way_;  ///< x0 and u
  Vector loads_;        ///< work space
  Vector load_;         ///< J^T l
};

}  // namespace stroma
