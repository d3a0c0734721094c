// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/integrators/conditioned_statics.h"

#include <algorithm>
#include <string>
#include <utility>

#include "components/integrators/constraint_sweeps.h"
#include "framework/simulation/integrator.h"
#include "framework/simulation/step_limits.h"

namespace stroma {
namespace {

constexpr double first_part = 0.25;  // of a step that is divided

bool isGood(const StepReport& report) { return report.newton_converged && report.constraints_converged && !report.failed(); }

std::string whyOf(const StepReport& report) {
  const std::string& why = report.reason.empty() ? report.constraint_reason : report.reason;
  return why.empty() ? "elements are turned inside out on the way" : why;
}

}  // namespace

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

StepReport ConditionedStatics::solveInParts(Newton& newton, LinearSolver& solver, const StepContext& context, const Advance& advance,
                                            const std::function<bool()>& retry, double smallest) {
  const auto solveWhole = [&] {
    return solve(newton, solver, context.stop, [&](StepReport& to) { return advance(context, to); }, retry);
  };
  Vector before(start_.count()), forces(start_.count());
  copy(x(), before), copy(multipliers_.lastForces(), forces);
  StepReport report = solveWhole();
  // beyond elements that were turned inside out on the way there may be another equilibrium
  const bool is_sure = isGood(report) && !conditions_.wasCrushed();
  if (report.stopped || is_sure || smallest > first_part) return report;
  Vector reached(start_.count());
  copy(x(), reached), copy(before, x());
  const bool has_way = multipliers_.keepInitialViolation() || system_->constraints().hasPrescribed();
  copy(reached, x());
  if (!has_way) return report;
  copy(before, x());
  double done = 0;
  StepReport divided = solveParts(newton, solver, context, advance, retry, smallest, done);
  addCounts(report, divided);
  if (divided.stopped || isGood(divided)) return divided;
  copy(before, x()), multipliers_.setLastForces(forces);
  if (isGood(report)) {
    addCounts(divided, report = solveWhole());
    return report;
  }
  divided.newton_converged = false, divided.diverged = true;
  divided.reason = fmt::format("{}; divided, the step reached {:.3g} of its prescribed motion and volumes, and could not go on: {}",
                               whyOf(report), done, whyOf(divided));
  // of the whole step, not of the last part
  divided.constraints_converged = report.constraints_converged, divided.constraint_reason = std::move(report.constraint_reason);
  return divided;
}

/// The first part is a quarter; after one that fails the next is a quarter of it, and after one that does not, twice as large.
StepReport ConditionedStatics::solveParts(Newton& newton, LinearSolver& solver, const StepContext& context, const Advance& advance,
                                          const std::function<bool()>& retry, double smallest, double& done) {
  constexpr double part_residual = 1e-4;
  const double whole_residual = newton.settings.relative_residual;
  Vector good(start_.count());
  copy(x(), good);
  StepReport report;
  double part = first_part;
  for (int parts = 2; part >= smallest; ++parts) {
    StepContext end = context;
    const double share = std::min(1.0, done + part);
    end.t_end = share < 1 ? context.t + share * context.dt : context.t_end;
    newton.settings.relative_residual = share < 1 ? std::max(part_residual, whole_residual) : whole_residual;
    multipliers_.setShare(share);
    copy(good, x());
    StepReport attempt = solve(newton, solver, end.stop, [&](StepReport& to) { return advance(end, to); }, retry);
    newton.settings.relative_residual = whole_residual;
    multipliers_.setShare(1);
    addCounts(report, attempt);
    report = std::move(attempt);
    report.load_parts = parts;
    const bool is_good = isGood(report) && !conditions_.wasCrushed();
    if (report.stopped || (is_good && share == 1)) return report;
    if (is_good) {
      done = share, part *= 2;
      copy(x(), good), multipliers_.stepTaken();
    } else {
      part /= 4;
    }
  }
  report.newton_converged = false;
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
