// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/integrators/conditioned_statics.h"

#include <utility>

#include "framework/simulation/step_limits.h"

namespace stroma {

void ConditionedStatics::compile(System& system) {
  system_ = &system;
  multipliers_.compile(system);
  if (empty()) return;
  whole_.compile(system);
  StepLimits limits;
  limits.compile(system);
  if (!limits.empty())
    throw ComponentError("statics find no forces of constraint beside BarrierContact",
                         "ConstraintContact instead of it, or EulerImplicitSolver");
  for (Vector* vector : {&start_, &way_, &load_}) vector->resize(system.independentRows());
  loads_.resize(system.allRows());
  conditions_.compile(system, *this, multipliers_, load_);
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

/// With the forces of constraint of the step before.
StepReport ConditionedStatics::solveFromStart(Newton& newton, LinearSolver& solver, StopToken stop,
                                              const std::function<bool(StepReport&)>& advance) {
  clear(way_), clear(load_);
  multipliers_.begin({.displacement = 1, .weight = 1, .has_velocities = false}, true);
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
