// SPDX-License-Identifier: LGPL-2.1-or-later
// Of an implicit step: Newton's method with forces of Lagrangian constraints (conditions_newton.h).
#include "components/integrators/implicit_step.h"

namespace stroma {

StepReport ImplicitStep::solveConditions(StopToken stop) {
  StepReport report;
  if (limits_.empty()) {
    startIterating();
  } else {  // these are heeded by a solve without forces of constraint but those carried
    report = solveIterating(stop);
    if (report.failed()) return report;
  }
  report = conditions_.solve(newton_, *solver_, stop, report);
  if (report.failed()) return report;
  graph_.assign(newton_.history().begin(), newton_.history().end());
  if (settings_component_) settings_component_->noteResult(report, newton_);
  takeBack(report);
  takeChange();
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
