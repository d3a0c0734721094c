// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/integrators/newton.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "components/integrators/exact_tangent.h"
#include "framework/simulation/step_progress.h"

namespace stroma {
namespace {

/// A residual that is more of the loads than this leaves no equilibrium, whatever it comes from.
constexpr double most_of_loads = 1e-3;

std::string tooSmallLoads(double attainable) {
  return fmt::format(
      "; the round-off of positions alone makes {:.2g}: the loads are too small for this stiffness at this distance from "
      "the origin",
      attainable);
}

}  // namespace

void Newton::compile(Index rows) {
  for (Vector* vector : {&residual_, &direction_, &trial_, &base_}) vector->resize(rows);
  history_.reserve(std::size_t(std::min(settings.iterations, 100000)) + 2);
}

bool Newton::converged(double now) const {
  return now <= settings.relative_residual * scale_ || now <= settings.absolute_residual || now <= enough_ ||
         (history_.size() > 1 && now <= settings.successive_residual * history_[history_.size() - 2]);
}

/// True when |R| is small by its relative tolerance alone, and parts of it are not by theirs: then an iteration more is made.
bool Newton::isForParts(const NonlinearProblem& problem, double now) {
  if (enough_ > 0) return false;
  const bool is_relative = settings.absolute_residual == 0 && settings.successive_residual == 0;
  if (!is_relative || now == 0 || int(history_.size()) > settings.iterations) return false;
  const double of_parts = problem.residualOfParts(residual_);
  if (of_parts <= settings.relative_residual || !(of_parts < 0.5 * parts_)) return false;
  parts_ = of_parts;
  return true;
}

/// An iteration for parts that fails leaves a solve that has converged before.
bool Newton::isLeftAsItWas(double now, StepReport& report) const {
  if (std::isinf(parts_) || !converged(now)) return false;
  report.diverged = false, report.linear_converged = true, report.linear_at_limit = false;
  report.reason.clear();
  return true;
}

/// The relative residual at which a solve ends.
double Newton::goal() const {
  return scale_ > 0 ? std::max({settings.relative_residual, settings.absolute_residual / scale_, enough_ / scale_})
                    : settings.relative_residual;
}

/// True when the correction is small enough to stop. It is the whole correction that counts: a step can be short because
/// the line search shortened it, far from a solution.
bool Newton::isCorrectionSmall(const NonlinearProblem& problem) const {
  if (settings.absolute_correction <= 0 && settings.relative_correction <= 0) return false;
  const double length = problem.displacementPerUnknown() * problem.lengthOf(direction_);
  return length <= settings.absolute_correction || length <= settings.relative_correction * problem.travelled();
}

/// True when it moves nothing by more than `part` of the largest position, and no frame by that as an angle.
bool Newton::isCorrectionWithin(double part, const NonlinearProblem& problem) const {
  if (const Motion* motion = problem.motionOfFrames()) {  // places have a unit, turns have none
    double size[2] = {0, 1}, way[2] = {0, 0};
    for (Index row = 0; row < direction_.count(); ++row) {
      const bool turns = motion->kindOf(row) == RowKind::turn;
      way[turns] = std::max(way[turns], problem.displacementPerUnknown() * direction_[row].lpNorm<Eigen::Infinity>());
      if (!turns) size[0] = std::max(size[0], problem.positions()[row].lpNorm<Eigen::Infinity>());
    }
    return way[0] <= part * size[0] && way[1] <= part * size[1];
  }
  return problem.displacementPerUnknown() * largest(direction_) <= part * largest(problem.positions());
}

/// True when |R| gets on too slowly for a solve that a caller can make in smaller parts.
bool Newton::isPointless() const {
  constexpr std::size_t first = 25;
  if (settings.patience == 0 || history_.size() <= first + 1) return false;
  return history_.back() > 0.5 * history_[history_.size() - 1 - std::size_t(settings.patience)];
}

/// Unstable directions keep showing, or |R| decreases hardly any more: damping by an unstable stiffness may be why.
bool Newton::mayBeDriven() const {
  constexpr int often = 3;
  constexpr std::size_t first = 10, last = 6;
  constexpr double hardly = 0.3;
  return unstable_solves_ >= often || (history_.size() > first && history_.back() > hardly * history_[history_.size() - 1 - last]);
}

/// Where |R| falls by much the same small factor in every iteration, as with a tangent that is an approximation: how many more
/// are needed; else 0. The way to where that begins and the last iterations are left alone.
double Newton::iterationsLeft() const {
  constexpr double smallest_factor = 0.1, largest_factor = 0.95;
  const std::size_t last = history_.size() - 1, count = std::size_t(settings.slow_factors);
  if (last < count + 1) return 0;
  for (std::size_t i = last - count + 1; i <= last; ++i)
    if (const double factor = history_[i] / history_[i - 1]; !(factor > smallest_factor && factor < largest_factor)) return 0;
  const double each = std::log(history_[last] / history_[last - count]) / double(count);
  return std::max(0.0, std::log(goal() * scale_ / history_[last]) / each);
}

/// True when round-off explains the whole residual, and that is little beside the loads, or there are none: nothing better exists.
/// Where round-off is not little, `report.reason` becomes the clause that says so.
bool Newton::isAtRoundOff(NonlinearProblem& problem, double now, StepReport& report) {
  report.reason.clear();
  if (in_focus_) return false;
  const double attainable = problem.roundOff().residual;
  if (!(now <= 3 * attainable)) return false;
  report.newton_residual = now / scale_;
  if (now <= most_of_loads * scale_) return true;
  const double loads = problem.loads();
  scale_ = std::max(scale_, loads);
  report.newton_residual = now / scale_;
  if (now <= most_of_loads * scale_ || loads == 0) return true;
  report.reason = tooSmallLoads(attainable / scale_);
  return false;
}

/// True where nothing acts, the first correction is nearly none and the forces are what round-off makes of them: that they
/// balance no better is no lack of balance.
bool Newton::isAtRest(NonlinearProblem& problem) {
  constexpr double nearly_none = 1e-9;
  if (!problem.isForceBalance() || history_.size() > 1) return false;
  if (!isCorrectionWithin(nearly_none, problem)) return false;
  return scale_ <= 3 * problem.roundOff().residual && problem.loads() == 0;
}

/// The relative residual that the next linear solve must reach; 0: what its solver is set to.
double Newton::forcingTerm(double now) const {
  const double end = std::max({settings.relative_residual * scale_, settings.absolute_residual, enough_}) / now;
  if (settings.forcing <= 0) return settings.is_linear && history_.size() > 1 ? settings.forcing_margin * end : 0;
  double term = settings.forcing;
  if (history_.size() > 1) term = went_on_ ? term * term : 0.9 * std::pow(now / history_[history_.size() - 2], 2);
  if (term < settings.forcing_reach * end) term = settings.forcing_margin * end;
  return std::min(term, settings.forcing);
}

/// The tolerance stays that of where the step starts. A guess that the line search refuses is left. Without an energy it is left
/// where something stands in its way or |R| grows: R.d, which then judges corrections, says little of a way that solves nothing.
void Newton::goToGuess(NonlinearProblem& problem, double& now) {
  if (!(scale_ > 0) || !problem.guess(direction_)) return;
  if (settings.use_energy) {
    if (search(problem, now) == 0) problem.residual(residual_);
    return;
  }
  copy(problem.unknowns(), base_);
  if (problem.longestStep(direction_) < 1) return;
  move(problem, 1);
  problem.residual(trial_);
  if (const double there = problem.sizeOf(trial_); there < now) return std::swap(residual_, trial_), void(now = there);
  move(problem, 0);
  problem.residual(residual_);
}

void Newton::keepIfBest(NonlinearProblem& problem, double now) {
  if (!(now < best_norm_) || (settings.use_energy && (history_.size() < 3 || !problem.mayMeetBarriers()))) return;
  if (best_.count() != base_.count()) best_.resize(base_.count());
  copy(problem.unknowns(), best_), best_norm_ = now;
}

void Newton::leaveBest(NonlinearProblem& problem, double now, StepReport& report) {
  report.newton_converged = false;
  // each iterate has less energy than those before, so that the last one is the best, but not where it presses a barrier until it is
  // farther from balance than the first
  if (!(best_norm_ < now) || (settings.use_energy && now <= scale_)) return;
  copy(best_, problem.unknowns());
  problem.unknownsChanged();
  problem.residual(residual_);
  report.newton_residual = best_norm_ / scale_;
}

StepReport Newton::solve(NonlinearProblem& problem, LinearSolver& solver, StopToken stop) {
  stop_ = stop, unstable_solves_ = 0;
  if (!was_slow_ && problem.hasRemainingMotion()) {
    clear(direction_);
    const bool is_free = problem.advanceRemainingMotion(direction_, true);
    if (!is_free && !problem.guess(direction_)) clear(direction_);
    if (!is_free) problem.advanceRemainingMotion(direction_);
  }
  StepReport report = solveAll(problem, solver);
  while (report.newton_converged && !report.failed() && problem.updatesLagged()) {
    const bool has_way = problem.hasRemainingMotion();
    if (has_way) advanceRemainingMotion(problem, solver, report);
    if (report.stopped) return report;
    keeps_scale_ = enough_ > 0 && !has_way;  // what was solved roughly is solved on
    const StepReport before = report;
    report = solveAll(problem, solver);
    addCounts(before, report);
  }
  return report;
}

/// What is moved goes on, and what it pushes gives way as the tangent has it: bodies that stood where they are would let it go but a
/// part of the gap in each solve, and gaps of what is pressed hard are small. The push is decades larger than what it leaves of the
/// forces, so that a rough solve would be of no use.
void Newton::advanceRemainingMotion(NonlinearProblem& problem, LinearSolver& solver, StepReport& report) {
  constexpr double tolerance = 1e-3;
  problem.residual(residual_);
  StepReport found;
  const bool pushes = std::isfinite(problem.sizeOf(residual_)) && problem.addPush(residual_);
  if (!pushes || !findDirection(problem, solver, tolerance, found)) clear(direction_);
  found.newton_iterations = pushes;
  addCounts(found, report);
  if (found.stopped) return void(report.stopped = true);
  problem.advanceRemainingMotion(direction_);
}

/// What moves on between solves stays where it is.
StepReport Newton::solveFixed(NonlinearProblem& problem, LinearSolver& solver) {
  StepReport report;
  constexpr double little = 0.1;
  problem.residual(residual_);
  if (!was_slow_ && !keeps_scale_) problem.updateNorms();
  double now = problem.sizeOf(residual_);
  enough_ = problem.isIntermediate() ? little * now : 0;
  went_on_ = std::exchange(was_slow_, false);
  if (went_on_) {  // from there
    history_.pop_back();
  } else {
    history_.clear();
    is_unstable_ = has_looked_ = false;
    parts_ = std::numeric_limits<double>::infinity();
    best_norm_ = std::numeric_limits<double>::infinity();
    if (!std::exchange(keeps_scale_, false)) takeScale(problem, now);
    if (!in_focus_) goToGuess(problem, now);
  }
  for (;;) {
    const int done = int(history_.size());
    history_.push_back(now);
    // what rests on something has next to no net force where the solve starts
    if (done == 2 && !in_focus_ && !converged(now) && !stop_.isStopAsked()) scale_ = std::max(scale_, problem.loads());
    report.newton_residual = scale_ > 0 ? now / scale_ : now;
    tellNewtonIterate(done, report.newton_residual, goal());
    if (!std::isfinite(now)) {
      report.diverged = true;
      report.reason = "the force is not finite where the step starts";
      return report;
    }
    if (converged(now) && !isForParts(problem, now)) {
      report.linear_converged = true, report.linear_at_limit = false;  // its solves were means only, to this residual
      return report;
    }
    report.stopped = stop_.isStopAsked();
    if (report.stopped || (settings.fixed_count && done == settings.iterations)) return report;
    if (settings.is_linear && done > 0 && isAtRoundOff(problem, now, report)) {  // corrections would be of round-off
      report.linear_converged = true, report.linear_at_limit = false;
      return report;
    }
    if (report.newton_iterations > 0) keepIfBest(problem, now);
    constexpr double few_iterations = 6;
    was_slow_ = settings.leaves_slow && iterationsLeft() > few_iterations;
    if (done == settings.iterations || isPointless() || was_slow_) {
      if (isAtRoundOff(problem, now, report)) return was_slow_ = false, report;
      leaveBest(problem, now, report);
      report.reason = fmt::format(
          "Newton's method stopped {} {} iterations with a relative residual of {:.2g} (tolerance {:.2g}){}",
          done == settings.iterations ? "at its limit of" : "without progress after", done, report.newton_residual,
          settings.relative_residual, report.reason);
      return report;
    }
    if (!iterate(problem, solver, now, report)) return report;
  }
}

/// One iteration. False when it is the last: converged by its correction, or failed as the report says.
bool Newton::iterate(NonlinearProblem& problem, LinearSolver& solver, double& now, StepReport& report) {
  ++report.newton_iterations;
  if (mayBeDriven() && problem.useDefiniteDamping()) problem.residual(residual_), now = problem.sizeOf(residual_);
  const double before = now, tolerance = forcingTerm(now);
  if (!findDirection(problem, solver, tolerance, report)) return isLeftAsItWas(now, report), false;
  if (isAtRest(problem)) return false;
  if (settings.looks_for_unstable_modes) lookForUnstableMode(problem, solver, now, report);
  const double step = searchSurely(problem, solver, tolerance, now, report);
  const bool shifted = report.linear_stop == SolveStop::not_definite || report.linear_stop == SolveStop::breakdown;
  if (step == 0) {
    report.stopped = report.stopped || stop_.isStopAsked();
    if (report.stopped || isLeftAsItWas(now, report)) return false;
    if (enough_ > 0) return report.reason.clear(), false;  // as good a place to go on from as any
    if (isAtRoundOff(problem, now, report)) return false;
    report.diverged = settings.fixed_count;
    leaveBest(problem, now, report);
    report.reason = fmt::format("the line search found no decrease at Newton iteration {}, relative residual {:.2g}{}",
                                report.newton_iterations, report.newton_residual, report.reason);
    return false;
  }
  const bool has_line = settings.use_energy && settings.line_search_iterations > 0 && !settings.stop_when_residual_grows;
  if (step == 1 && has_line && problem.mayMeetBarriers()) goOn(problem, dot(trial_, direction_), now);  // the residual of before
  if (settings.stop_when_residual_grows && now > before) {
    report.diverged = true, report.newton_converged = false;
    report.reason = fmt::format("the residual grew from {:.3g} to {:.3g} N at Newton iteration {}", before, now,
                                report.newton_iterations);
    return false;
  }
  const bool is_round_off = isCorrectionWithin(2 * std::numeric_limits<double>::epsilon(), problem);
  if (shifted || !(is_round_off || isCorrectionSmall(problem))) return true;
  history_.push_back(now);
  report.newton_residual = now / scale_;
  if (!is_round_off || now <= most_of_loads * scale_ || settings.fixed_count) return false;
  const double loads = problem.loads(), attainable = problem.roundOff().residual;
  // a body on which nothing acts has a residual of round-off from the start
  const bool is_at_rest = loads == 0 && std::min(scale_, now) <= 3 * attainable;
  scale_ = std::max(scale_, loads);
  report.newton_residual = now / scale_;
  if (is_at_rest || now <= most_of_loads * scale_) return false;
  report.newton_converged = false;
  report.reason = fmt::format("Newton's corrections are below the round-off of positions at a relative residual of {:.2g}{}",
                              report.newton_residual, tooSmallLoads(attainable / scale_));
  return false;
}

}  // namespace stroma
