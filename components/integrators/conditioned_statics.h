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

/// What follows a node that has moved in the solve has its place only after it: `advance` and `solve` alternate until the former
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

/// Equilibrium with forces of constraint, f(x) + J^T l = 0 in the free directions, and the conditions of Lagrangian constraints.
/// The unknown u is the way since the step began: x = x0 + u, where rows that turn do so by the rotation vector in u.
class ConditionedStatics final : public NonlinearProblem {
 public:
  void declare(DataTable& table) { multipliers_.declare(table); }
  /// Throws ComponentError where something bounds steps that this does not ask.
  void compile(System& system);
  /// No Lagrangian constraint is there.
  bool empty() const { return multipliers_.empty(); }
  /// Where a step starts: no condition needs a force there.
  bool areFree() { return multipliers_.begin(rule, true), multipliers_.areFree(); }
  /// At the end of a step that was made so: none does there, and none is given.
  bool stayFree() { return multipliers_.areFree() && (multipliers_.giveNone(), true); }
  /// A step from the present x, in one go: conditions are of its end. `advance` moves x where motion is prescribed, and is false
  /// when that is there; `retry` changes the tangent after a solve that failed, for another one from the same x, or is false.
  StepReport solve(Newton& newton, LinearSolver& solver, StopToken stop, const std::function<bool(StepReport&)>& advance,
                   const std::function<bool()>& retry);
  using Advance = std::function<bool(const StepContext&, StepReport&)>;
  /// The same; a step that fails, or turns elements inside out on its way, and that moves something or is to change a length or a
  /// volume, is divided into parts of `smallest` or more of it, which begin with the forces of constraint of the part before. Prescribed
  /// motion goes with the time of a part, conditions hold by its share (Multipliers::setShare). `advance` goes to the end of a part.
  StepReport solveInParts(Newton& newton, LinearSolver& solver, const StepContext& context, const Advance& advance,
                          const std::function<bool()>& retry, double smallest);
  /// J^T l of the step before [N].
  void addCarried(Rows out) const { multipliers_.addCarried(out); }
  void stepTaken() { multipliers_.stepTaken(); }
  void reset() { multipliers_.reset(); }
  void serialize(Archive& archive) { multipliers_.serialize(archive), measure_.serialize(archive, "length_with_conditions"); }

  // ---- as equations for Newton's method ----
  void residual(Rows out) override;
  SystemMatrix& tangent() override { return whole_.of(system_->matrix().withFactors({.stiffness = -1})); }
  void keepToFree(Rows d) const override { stroma::keepToFree(*system_, d); }
  double energy() override { return 0; }  // not asked for
  Rows unknowns() override { return way_; }
  void unknownsChanged() override;
  double displacementPerUnknown() const override { return 1; }
  LightBodies* lightBodies() override { return &bodies_; }
  ConstRows positions() const override { return x(); }
  void takeMeasure() override {
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
