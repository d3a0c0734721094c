// SPDX-License-Identifier: LGPL-2.1-or-later
// Of an implicit step: Newton's method with forces of Lagrangian constraints (conditions_newton.h).
#include "components/integrators/implicit_step.h"

namespace stroma {

/// Where no force of constraint acts, the step is first made as if there were no conditions, in parts too. It stands where they hold: with
/// barriers the solve with forces goes on from there otherwise, else from where the step starts.
StepReport ImplicitStep::solveConditions(StopToken stop) {
  StepReport report;
  const bool may_be_free = multipliers_.areFree();
  if (may_be_free || !limits_.empty()) {
    is_free_ = may_be_free;
    report = iterates() ? solveIterating(stop) : solveAsNeeded(stop);
    is_free_ = false;
    if (report.stopped || (report.failed() && !limits_.empty())) return report;
    if (may_be_free && !report.failed() && multipliers_.areFree()) {  // not converged too: forces of constraint would not help
      multipliers_.giveNone();
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

void ImplicitStep::takeChange() {
  copy(v(), change_);
  axpy(-1, v0_, change_);
}

}  // namespace stroma
