// SPDX-License-Identifier: LGPL-2.1-or-later
// Part of an implicit step: a prescribed motion that is too large for a single solve. Moving only the prescribed nodes crushes
// the elements next to them, and Newton's method starts from a state without a finite energy, or from inverted elements. A
// part of the step solves
//
//   R(u) = 0,   moved nodes at x0 + s d
//
// with d their displacement in the step, and s grows to 1 as in statics (static_solver.cpp). The start of each part is
// predicted with the tangent at the end of the last one: A du = R + A_m d spreads the motion over all nodes. With Lagrangian
// constraints, R has the forces found by the last part, and each part solves for its own. Steps with possible contact have
// separate code (implicit_ways.cpp).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "components/integrators/implicit_step.h"

namespace stroma {

constexpr double near_enough = 1e-2;  ///< of the forces: what has come so near has not started from too large a motion

/// Whether a solve that ended so may be one that has started from too large a motion. What has nearly balanced is not.
bool ImplicitStep::mayDivide(const StepReport& report) const {
  constexpr int fewest = 5;  // else a scene that is content with what they leave asks for no more
  if (report.stopped || !limits_.empty()) return false;
  if (newton_.settings.iterations < fewest && newton_.settings.keep_unconverged && !report.diverged) return false;
  if (!system_->constraints().hasPrescribed() || newton_.settings.stop_when_residual_grows) return false;
  return report.diverged || (!report.newton_converged && !(report.newton_residual <= near_enough));
}

/// The way of what is held, into carried_; false where there is none.
bool ImplicitStep::findWayOfHeld() {
  carried_.resize(x().count);
  copy(v0_, work_);
  scale(scheme_.drift, work_);
  if (scheme_.has_history) axpy(1, position_predictor, work_);
  copy(work_, carried_);
  system_->constraints().project(work_);
  axpy(-1, work_, carried_);
  return largest(carried_) > 4 * std::numeric_limits<double>::epsilon() * largest(x0_);
}

/// From a state u at which the moved nodes have a part of their way behind them to one where they have `more` of it; the rest goes
/// where the tangent carries it. False where that is nowhere.
bool ImplicitStep::carryOn(double more, StopToken stop, StepReport& report) {
  System& s = *system_;
  const Rows right = s.independent(right_side_), d = change_;
  residual(right);
  const MatrixFactors factors = tangentFactors();
  copy(carried_, work_);
  scale(-more / scheme_.displacement, work_);
  clear(d);
  s.addMassProduct(work_, factors.mass, d);
  s.addStiffnessProduct(work_, factors, d);
  s.constraints().project(d);
  axpy(1, d, right);
  StepReport found;
  const bool is_found = std::isfinite(norm(right)) && solveOrShift(*solver_, tangent(), right, d, {.stop = stop}, found);
  addCounts(found, report);
  report.stopped = found.stopped;
  if (!is_found) return false;
  s.constraints().project(d);
  addTo(v(), 1, d);
  axpy(more / scheme_.displacement, carried_, v());
  unknownsChanged();
  residual(right);
  return std::isfinite(norm(right)) && (!newton_.settings.use_energy || std::isfinite(energy()));
}

/// After a solve of the whole step that failed as `whole` says. Where nothing moves that is left, else the step is divided or fails.
StepReport ImplicitStep::solveInParts(const StepReport& whole, StopToken stop) {
  constexpr double smallest_part = 1.0 / 1024, part_residual = 1e-4;
  if (!findWayOfHeld()) return whole;
  copy(x0_, x()), copy(v0_, v());
  startIterating();
  good_.resize(x().count);
  copy(v(), good_);
  axpy(-1 / scheme_.displacement, carried_, good_);
  // with forces of constraint: those where the last part ended, and the load that has them
  Vector good_forces, good_load;
  const auto keepForces = [&] {
    if (!hasForces()) return;
    for (Vector* vector : {&good_forces, &good_load}) vector->resize(x().count);
    copy(multipliers_.carried(), good_forces), copy(constant_, good_load);
  };
  keepForces();
  StepReport report = whole;
  const double end_residual = newton_.settings.relative_residual;
  double done = 0, part = 1;
  for (int parts = 2; part >= smallest_part; ++parts) {
    const double share = std::min(1.0, done + part);
    copy(good_, v());
    if (hasForces()) multipliers_.restoreCarried(good_forces), copy(good_load, constant_);
    unknownsChanged();
    newton_.settings.relative_residual = share < 1 ? std::max(part_residual, end_residual) : end_residual;
    StepReport attempt;
    const bool is_carried = carryOn(share - done, stop, attempt);
    if (is_carried) {
      const StepReport before = attempt;
      attempt = hasForces() ? conditions_.solve(newton_, *solver_, stop, {}) : solveFromHere(stop);
      addCounts(before, attempt);
    }
    newton_.settings.relative_residual = end_residual;
    addCounts(report, attempt);
    const bool good = is_carried && attempt.newton_converged && attempt.constraints_converged && !attempt.failed();
    report = attempt;
    report.load_parts = parts;
    // few iterations may end before the tolerance, as in any step
    const bool is_near = is_carried && newton_.settings.keep_unconverged && !attempt.failed() && attempt.newton_residual <= near_enough;
    if (report.stopped || ((good || is_near) && share == 1)) return report;
    if (good && is_free_ && !multipliers_.areFree()) return report.newton_converged = false, report;  // parts with forces follow
    if (good) {
      done = share, part *= 2;
      copy(v(), good_);
      keepForces();
    } else {
      part /= 4;
    }
  }
  report.diverged = true, report.newton_converged = false;
  const std::string last = report.reason.empty() ? report.constraint_reason : report.reason;
  report.reason = fmt::format("{}; divided, the step reached {:.3g} of its prescribed motion, and no part of {:.2g} beyond{}{}",
                              whole.reason, done, 4 * part, last.empty() ? "" : ": ", last);
  return report;
}

}  // namespace stroma
