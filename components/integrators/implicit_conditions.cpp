// SPDX-License-Identifier: LGPL-2.1-or-later
// Newton's method for the balance of forces and the conditions of Lagrangian constraints at once,
//
//   R(u) + J(x)^T p = 0,   g(x(u)) = 0 (or the inequalities of what pushes and rubs)
//
// With q = J^T p of the iterate before and A = -dR/du there, an iteration is A d = R + q, u += d, and the correction of
// multipliers.h with the same A and J^T, from which q comes anew. The first one is the linearised step. No later one goes
// further than that; and where the conditions hold already, |R + q| must fall, or u and q go a share of their way. What is not
// there after four iterations, because A lacks the turning of stresses and of forces of constraint, goes on with iterates
// mixed (mixing.h).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "components/integrators/implicit_step.h"
#include "framework/simulation/step_progress.h"

namespace stroma {

StepReport ImplicitStep::solveConditions(StopToken stop) {
  StepReport report;
  if (limits_.empty()) {
    startIterating();
  } else {  // these are heeded by a solve without forces of constraint but those carried
    report = solveIterating(stop);
    if (report.failed()) return report;
  }
  multipliers_.aim();
  longest_ = moved_ = 0, iterations_ = 0;
  mixing_.restart();
  holds_ = false;
  std::vector<double>& history = newton_.history();
  history.clear();
  const int first = report.newton_iterations, most = newton_.settings.iterations;
  const Rows r = system_->independent(right_side_);
  residual(r);
  for (double now = norm(r);;) {
    if (history.empty()) residual_scale_ = std::max(now, loadScale());
    residual_scale_ = std::max(residual_scale_, multipliers_.carriedSize());
    history.push_back(now);
    report.newton_residual = residual_scale_ > 0 ? now / residual_scale_ : now;
    tellNewtonIterate(report.newton_iterations, report.newton_residual, newton_.settings.relative_residual);
    if (!std::isfinite(now)) {
      report.diverged = true;
      report.reason = "the force is not finite in Newton's method with forces of constraint";
      return report;
    }
    if (isBalanced(now, report)) break;
    report.stopped = stop.isStopAsked();
    if (report.stopped) return report;
    if (newton_.settings.fixed_count && report.newton_iterations == most) break;
    if (report.newton_iterations - first == most) {
      report.newton_converged = false;
      report.reason = fmt::format("Newton's method with forces of constraint stopped at its limit of {} iterations with a "
                                  "relative residual of {:.2g} (tolerance {:.2g})",
                                  most, report.newton_residual, newton_.settings.relative_residual);
      break;
    }
    if (!iterateConditions(now, stop, report)) return report;
  }
  graph_.assign(history.begin(), history.end());
  if (settings_component_) settings_component_->noteResult(report, newton_);
  takeBack(report);
  takeChange();
  return report;
}

bool ImplicitStep::isLittle(double residual) const {
  return residual <= newton_.settings.relative_residual * residual_scale_ || residual <= newton_.settings.absolute_residual;
}

/// The conditions hold, and what is left of the forces is little, or the round-off of positions.
bool ImplicitStep::isBalanced(double residual, StepReport& report) {
  if (!holds_) return false;
  const bool is_still = moved_ <= 4 * std::numeric_limits<double>::epsilon() * largest(x());
  if (!isLittle(residual) && !is_still) return false;
  report.linear_converged = true, report.linear_at_limit = false;  // its solves were means only
  return true;
}

/// `now`: |R + q|, before and after. False: failed, as the report says.
bool ImplicitStep::iterateConditions(double& now, StopToken stop, StepReport& report) {
  ++report.newton_iterations, ++iterations_;
  const Rows r = system_->independent(right_side_);
  const bool held = holds_;
  copy(v(), last_v_);
  if (!solveOrShift(*solver_, tangent(), r, direction_, {.stop = stop}, report)) return false;
  report.reason.clear();
  axpy(1, direction_, v());
  unknownsChanged();
  takeChange();
  report.constraints_converged = true;
  report.constraint_reason.clear();
  multipliers_.correct(*solver_, tangent(), change_, stop, report);
  if (report.failed()) return false;
  multipliers_.carry(constant_);
  holds_ = true;
  copy(v(), direction_);
  axpy(-1, last_v_, direction_);
  moved_ = scheme_.displacement * norm(direction_);
  residual(r);
  const double before = std::exchange(now, norm(r));
  if (isLittle(now) || newton_.settings.fixed_count) return true;
  if (longest_ == 0) longest_ = moved_;
  if (moved_ > longest_) {
    goShare(longest_ / moved_);
    residual(r);
    now = norm(r);
  }
  constexpr int first_mixed = 4;
  if (iterations_ > first_mixed && longest_ > 0) {
    multipliers_.carryMixed(mixing_, last_v_, v(), constant_);
    unknownsChanged();
    multipliers_.aim();
    holds_ = false;
    residual(r);
    now = norm(r);
    return true;
  }
  constexpr double smallest = 1. / 32;
  for (double share = std::min(1.0, longest_ / moved_) / 2; held && !(now <= before) && share > smallest; share /= 2) {
    goShare(share);
    residual(r);
    now = norm(r);
  }
  return true;
}

/// u and q of the last iteration go this share of their way.
void ImplicitStep::goShare(double share) {
  copy(last_v_, v());
  axpy(share, direction_, v());
  unknownsChanged();
  multipliers_.carryShare(share, constant_);
  multipliers_.aim();
  holds_ = false;
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
