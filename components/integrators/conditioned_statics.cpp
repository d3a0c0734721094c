// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/integrators/conditioned_statics.h"

#include <algorithm>
#include <string>
#include <utility>

#include "components/integrators/constraint_sweeps.h"
#include "framework/simulation/integrator.h"
#include "framework/simulation/step_limits.h"

namespace stroma {

void ConditionedStatics::compile(System& system) {
  system_ = &system;
  multipliers_.compile(system);
  if (empty()) return;
  ConstraintSweeps::tellIdle(system.integrator(), system.integrator().path() + " finds equilibria");
  whole_.compile(system), measure_.compile(system.motion());
  StepLimits limits;
  limits.compile(system);
  if (!limits.empty())
    throw ComponentError("statics find no forces of constraint beside BarrierContact",
                         "ConstraintContact instead of it, or EulerImplicitSolver");
  for (Vector* vector : {&start_, &way_, &load_}) vector->resize(system.independentRows());
  loads_.resize(system.allRows());
  conditions_.compile(system, *this, multipliers_, load_), bodies_.compile(system);
}

StepReport ConditionedStatics::solve(Newton& newton, LinearSolver& solver, StopToken stop,
                                     const std::function<bool(StepReport&)>& advance, const std::function<bool()>& retry) {
  copy(x(), start_);
  StepReport report = solveFromStart(newton, solver, stop, advance);
  if (report.stopped || (report.newton_converged && !report.diverged) || !retry()) return report;
  copy(start_, x());
  const StepReport before = std::exchange(report, solveFromStart(newton, solver, stop, advance));
  addCounts(before, report);
  return report;
}

StepReport ConditionedStatics::solveInParts(Newton& newton, LinearSolver& solver, const StepContext& context,
                                            const std::function<bool(const StepContext&, StepReport&)>& advance,
                                            const std::function<bool()>& retry, double smallest) {
  constexpr double part_residual = 1e-4, first_part = 0.25;
  const auto solveTo = [&](const StepContext& end) {
    return solve(newton, solver, end.stop, [&](StepReport& to) { return advance(end, to); }, retry);
  };
  const auto isGood = [](const StepReport& report) {
    return report.newton_converged && report.constraints_converged && !report.failed();
  };
  StepReport report = solveTo(context);
  if (report.stopped || isGood(report) || smallest > first_part || !system_->constraints().hasPrescribed()) return report;
  const std::string why = report.reason.empty() ? report.constraint_reason : report.reason;
  const double whole_residual = newton.settings.relative_residual;
  Vector before(start_.count()), good(start_.count()), forces(start_.count());
  copy(start_, before), copy(start_, good), copy(multipliers_.lastForces(), forces);
  double done = 0, part = first_part;
  for (int parts = 2; part >= smallest; ++parts) {
    StepContext end = context;
    const double share = std::min(1.0, done + part);
    end.t_end = share < 1 ? context.t + share * context.dt : context.t_end;
    newton.settings.relative_residual = share < 1 ? std::max(part_residual, whole_residual) : whole_residual;
    copy(good, x());
    StepReport attempt = solveTo(end);
    newton.settings.relative_residual = whole_residual;
    addCounts(report, attempt);
    report = std::move(attempt);
    report.load_parts = parts;
    if (report.stopped || (isGood(report) && share == 1)) return report;
    if (isGood(report)) {
      done = share, part *= 2;
      copy(x(), good), multipliers_.stepTaken();
    } else {
      part /= 4;
    }
  }
  copy(before, x()), multipliers_.setLastForces(forces);
  report.newton_converged = false, report.diverged = true;
  const std::string last = report.reason.empty() ? report.constraint_reason : report.reason;
  report.reason = fmt::format("{}; divided, the step reached {:.3g} of its prescribed motion, and no part of {:.2g} beyond{}{}", why, done,
                              4 * part, last.empty() ? "" : ": ", last);
  return report;
}

/// With the forces of constraint of the step before.
StepReport ConditionedStatics::solveFromStart(Newton& newton, LinearSolver& solver, StopToken stop,
                                              const std::function<bool(StepReport&)>& advance) {
  clear(way_), clear(load_);
  multipliers_.begin(rule, true);
  multipliers_.addCarried(load_);
  return solveWithFollowers(advance, [&] {
    copy(start_, way_);
    system_->motion().difference(x(), way_);
    return conditions_.solve(newton, solver, stop, {});
  });
}

void ConditionedStatics::residual(Rows out) {
  system_->computeForce(system_->x, system_->v, system_->f);
  copy(system_->independent(system_->f), out);
  axpy(1, load_, out);
  system_->constraints().project(out);
}

void ConditionedStatics::unknownsChanged() {
  copy(start_, x());
  system_->motion().advance(1, way_, x());
}

}  // namespace stroma
