// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/integrators/conditioned_statics.h"

#include "components/integrators/exact_tangent.h"
#include "framework/simulation/step_limits.h"

namespace stroma {

void ConditionedStatics::compile(System& system) {
  system_ = &system;
  multipliers_.compile(system);
  if (empty()) return;
  StepLimits limits;
  limits.compile(system);
  if (!limits.empty())
    throw ComponentError("statics find no forces of constraint beside BarrierContact",
                         "ConstraintContact instead of it, or EulerImplicitSolver");
  for (Vector* vector : {&start_, &way_, &load_}) vector->resize(system.independentRows());
  conditions_.compile(system, *this, multipliers_, load_);
}

StepReport ConditionedStatics::solve(Newton& newton, LinearSolver& solver, StopToken stop,
                                     const std::function<bool(StepReport&)>& advance, const std::function<bool()>& retry) {
  constexpr int most_solves = 4;  // what follows a node that has moved in the solve has its place only after it
  copy(x(), start_), clear(way_), clear(load_);
  multipliers_.begin({.displacement = 1, .weight = 1, .has_velocities = false}, true);
  multipliers_.addCarried(load_);
  StepReport report;
  const auto goOn = [&] {
    const StepReport before = report;
    report = conditions_.solve(newton, solver, stop, {});
    addCounts(before, report);
  };
  for (int again = 0; again < most_solves && report.newton_converged && !report.failed(); ++again) {
    StepReport moved;
    if (!advance(moved) && again > 0) break;
    if (!moved.newton_converged || moved.stopped) return moved;
    copy(start_, way_);
    system_->motion().difference(x(), way_);
    goOn();
    addCounts(moved, report);
  }
  if (!report.stopped && (report.diverged || !report.newton_converged) && retry()) goOn();
  return report;
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
