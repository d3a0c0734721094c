// SPDX-License-Identifier: LGPL-2.1-or-later
// Of an implicit step: Newton's method with forces of Lagrangian constraints (conditions_newton.h).
#include "components/integrators/implicit_step.h"
#include "components/integrators/while_on.h"

namespace stroma {

/// Where no force of constraint acts, the step is first made as if there were no conditions, in parts too. It stands where it is solved
/// and they hold: with barriers the solve with forces goes on from there otherwise, else from where the step starts. A body may have no
/// balance on its way to the places that would stop it.
StepReport ImplicitStep::solveConditions(StopToken stop) {
  StepReport report;
  const bool may_be_free = multipliers_.areFree();
  if (may_be_free || !limits_.empty()) {
    const auto solveOnce = [&] { return iterates() ? solveIterating(stop) : solveAsNeeded(stop); };
    report = may_be_free ? whileOn(is_free_, solveOnce) : solveOnce();
    if (report.stopped || (report.failed() && !limits_.empty())) return report;
    const bool is_solved = !report.failed() && (report.newton_converged || !iterates());
    if (may_be_free && is_solved && multipliers_.areFree()) {
      multipliers_.clearForces();
      return report;
    }
  }
  if (limits_.empty()) {
    if (may_be_free) report = startAgain(report);
    exact_.end();  // which forces of constraint do without
    startIterating();
  }
  report = conditions_.solve(newton_, *solver_, stop, report);
  if (mayDivide(report)) {
    copy(x0_, x()), copy(v0_, v());
    multipliers_.begin(rule_, true);
    report = solveInParts(report, stop);
  }
  if (report.failed()) return report;
  graph_.assign(newton_.history().begin(), newton_.history().end());
  if (settings_component_) settings_component_->noteResult(report, newton_);
  takeBack(report);
  takeChange();
  return report;
}

/// With the counts of what has been done for nothing.
StepReport ImplicitStep::startAgain(const StepReport& before) {
  copy(x0_, x());
  copy(v0_, v());
  StepReport report;
  addCounts(before, report);
  return report;
}

/// The state before the step, where one that has not converged is not wanted.
void ImplicitStep::takeBack(StepReport& report) {
  if (report.newton_converged || newton_.settings.keep_unconverged) return;
  copy(x0_, x());
  copy(v0_, v());
  report.reason += "; the state before the step was kept";
}

/// Of points that have passed a corner; what is taken back has passed none.
void ImplicitStep::turnVelocities(StopToken stop, StepReport& report) {
  const bool stands = !report.failed() && (report.newton_converged || newton_.settings.keep_unconverged);
  if (!stands || multipliers_.empty()) return;
  copy(v(), work_);
  if (multipliers_.turnVelocities(*solver_, tangent(), stop, report)) axpy(1, v(), change_), axpy(-1, work_, change_);
}

void ImplicitStep::takeChange() {
  copy(v(), change_);
  axpy(-1, v0_, change_);
}

}  // namespace stroma
