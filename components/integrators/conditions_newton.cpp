// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/integrators/conditions_newton.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "components/integrators/light_bodies.h"
#include "framework/simulation/step_progress.h"

namespace stroma {

void ConditionsNewton::compile(System& system, NonlinearProblem& problem, Multipliers& multipliers, Rows load) {
  problem_ = &problem, multipliers_ = &multipliers, load_ = load;
  for (Vector* vector : {&residual_, &direction_, &last_, &way_, &unmixed_, &unmixed_forces_}) vector->resize(system.independentRows());
}

double ConditionsNewton::residual() {
  problem_->residual(residual_);
  return size();
}

double ConditionsNewton::size() const {
  const LightBodies* const bodies = problem_->lightBodies();
  return std::hypot(problem_->sizeOf(residual_), bodies ? scale_ * bodies->left(residual_) : 0);
}

StepReport ConditionsNewton::solve(Newton& newton, LinearSolver& solver, StopToken stop, StepReport report) {
  const NewtonSettings& settings = newton.settings;
  multipliers_->updateDirections();
  longest_ = moved_ = 0, iterations_ = 0, swings_ = was_crushed_ = false;
  least_ = std::numeric_limits<double>::infinity(), least_at_ = 0;
  clear(way_);
  mixing_.restart();
  holds_ = false, left_ = nullptr;
  std::vector<double>& history = newton.history();
  history.clear();
  const int first = report.newton_iterations, most = settings.iterations;
  problem_->residual(residual_);
  problem_->updateNorms();
  if (LightBodies* const bodies = problem_->lightBodies()) bodies->begin(residual_, problem_->weightOfForces());
  for (double now;;) {
    const double of_all = problem_->sizeOf(residual_);
    if (history.empty()) scale_ = std::max(of_all, problem_->loadScale());
    scale_ = std::max(scale_, problem_->sizeOf(multipliers_->carried()));
    history.push_back(of_all);
    report.newton_residual = scale_ > 0 ? of_all / scale_ : of_all;
    tellNewtonIterate(report.newton_iterations, report.newton_residual, settings.relative_residual);
    if (!std::isfinite(of_all)) {
      report.diverged = true;
      report.reason = "the force is not finite in Newton's method with forces of constraint";
      return report;
    }
    if (isBalanced(settings, of_all, report)) break;
    report.stopped = stop.isStopAsked();
    if (report.stopped) return report;
    constexpr int most_left = 25;  // beyond a fixed number, for conditions that no forces along their directions have held
    const int done = report.newton_iterations - first;
    if (settings.fixed_count && done >= most && (!multipliers_->wasLeft() || done >= most + most_left)) break;
    if (swings_ || (done == most && !settings.fixed_count)) {
      report.newton_converged = false;
      const std::string how =
          swings_ ? fmt::format("goes to and fro by {:.2g} m, as constraints tolerate, after {} iterations", moved_, iterations_)
                  : fmt::format("stopped at its limit of {} iterations", most);
      report.reason = fmt::format("Newton's method with forces of constraint {} with a relative residual of {:.2g} "
                                  "(tolerance {:.2g}){}",
                                  how, report.newton_residual, settings.relative_residual, tellLeft(settings));
      break;
    }
    now = size();
    if (!iterate(newton, solver, now, stop, report)) return report;
  }
  return report;
}

bool ConditionsNewton::isLittle(const NewtonSettings& settings, double residual) const {
  return residual <= settings.relative_residual * scale_ || residual <= settings.absolute_residual;
}

bool ConditionsNewton::isAllLittle(const NewtonSettings& settings) {
  if (!isLittle(settings, problem_->sizeOf(residual_))) return false;
  const LightBodies* const bodies = problem_->lightBodies();
  return !bodies || bodies->areLittle(residual_, settings.relative_residual) || areBodiesBalanced(settings);
}

/// The conditions hold, and what is left of the forces is little, or the round-off of positions.
bool ConditionsNewton::isBalanced(const NewtonSettings& settings, double residual, StepReport& report) {
  if (!holds_) return false;
  const bool is_still = moved_ <= 4 * std::numeric_limits<double>::epsilon() * largest(problem_->positions());
  if (!isLittle(settings, residual) && !is_still) return false;
  if (!is_still && !areBodiesBalanced(settings)) return false;
  report.linear_converged = true, report.linear_at_limit = false;  // its solves were means only
  return true;
}

/// |R + q| of all does not see one that is decades lighter than others.
bool ConditionsNewton::areBodiesBalanced(const NewtonSettings& settings) {
  LightBodies* const bodies = problem_->lightBodies();
  if (!bodies || settings.absolute_residual != 0 || settings.fixed_count) return true;
  const std::size_t before = bodies->found();
  const State* const left = bodies->outOfBalance(residual_, multipliers_->carried(), settings.relative_residual,
                                                 problem_->weightOfForces(), problem_->tangent(), problem_->displacementPerUnknown());
  if (!left) return true;
  left_ = left;
  // what was measured without it is of another size
  if (bodies->found() > before) mixing_.restart(), least_ = std::numeric_limits<double>::infinity();
  return false;
}

std::string ConditionsNewton::tellLeft(const NewtonSettings& settings) const {
  const LightBodies* const bodies = problem_->lightBodies();
  if (!left_ || bodies->areLittle(residual_, settings.relative_residual)) return {};
  return fmt::format(", and bodies beside heavier ones are out of balance by {:.2g} of the forces on them, {} the most",
                     bodies->left(residual_), left_->path());
}

/// Where the conditions hold: `now`, of size(), has not become half of the least for longer than mixing needs, and the way turns.
void ConditionsNewton::noteOscillation(double now) {
  constexpr int long_enough = 12;
  constexpr double part = 1e-4;  // of the scale
  if (!(now > 0.5 * least_)) least_ = now, least_at_ = iterations_;
  const bool turns = dot(direction_, way_) < 0;
  copy(direction_, way_);
  swings_ = turns && iterations_ >= least_at_ + long_enough && now <= least_ && now <= part * scale_ &&
            moved_ <= multipliers_->leastTolerance(false);
}

/// `now`: size(), before and after. False: failed, as the report says.
bool ConditionsNewton::iterate(Newton& newton, LinearSolver& solver, double& now, StopToken stop, StepReport& report) {
  ++report.newton_iterations, ++iterations_;
  const bool held = holds_;
  const Rows u = problem_->unknowns();
  copy(u, last_);
  if (!solveOrShift(solver, problem_->tangent(), residual_, direction_, {.stop = stop}, report)) return false;
  problem_->projectToFree(direction_);
  report.reason.clear();
  axpy(1, direction_, u);
  problem_->unknownsChanged();
  report.constraints_converged = true;
  report.constraint_reason.clear();
  multipliers_->correct(solver, problem_->tangent(), problem_->changeSinceStart(), direction_, stop, report);
  if (report.failed()) return false;
  multipliers_->carry(load_);
  holds_ = !multipliers_->wasLeft();
  copy(u, direction_);
  axpy(-1, last_, direction_);
  moved_ = problem_->displacementPerUnknown() * norm(direction_);
  const double before = std::exchange(now, residual());
  noteOscillation(now);
  if (longest_ == 0) longest_ = moved_;
  if (!std::isfinite(now)) {
    goWhereFinite(now);
    return true;
  }
  // what ends is left where the conditions hold
  const bool is_last = iterations_ >= newton.settings.iterations && moved_ <= longest_;
  if (isAllLittle(newton.settings) || swings_ || is_last || newton.settings.fixed_count) return true;
  if (moved_ > longest_) goShare(longest_ / moved_), now = residual();
  constexpr int first_mixed = 4;
  if (iterations_ > first_mixed && longest_ > 0) {
    goMixed(now);
    return true;
  }
  constexpr double smallest = 1. / 32;
  for (double share = std::min(1.0, longest_ / moved_) / 2; held && !(now <= before) && share > smallest; share /= 2)
    goShare(share), now = residual();
  return true;
}

/// Elements that the whole correction would turn inside out have no energy: it goes a share of its way.
void ConditionsNewton::goWhereFinite(double& now) {
  constexpr double smallest = 1. / 4096;
  was_crushed_ = true;
  for (double share = 0.5; !std::isfinite(now) && share > smallest; share /= 2) goShare(share), now = residual();
}

/// u and q of the last iteration go this share of their way.
void ConditionsNewton::goShare(double share) {
  const Rows u = problem_->unknowns();
  copy(last_, u);
  axpy(share, direction_, u);
  problem_->unknownsChanged();
  multipliers_->carryShare(share, load_);
  multipliers_->updateDirections();
  holds_ = false;
}

/// Where the mixed iterate crushes elements, the last one stands as it is.
void ConditionsNewton::goMixed(double& now) {
  const double without = now;
  const Rows u = problem_->unknowns();
  copy(u, unmixed_), copy(multipliers_->carried(), unmixed_forces_);
  multipliers_->carryMixed(mixing_, last_, u, load_);
  problem_->unknownsChanged();
  now = residual();
  if (!std::isfinite(now) && std::isfinite(without)) {
    copy(unmixed_, u);
    axpy(-1, multipliers_->carried(), load_);
    axpy(1, unmixed_forces_, load_);
    multipliers_->restoreCarried(unmixed_forces_);
    mixing_.restart();
    problem_->unknownsChanged();
    now = residual();
  }
  multipliers_->updateDirections();
  holds_ = false;
}

}  // namespace stroma
