// SPDX-License-Identifier: LGPL-2.1-or-later
// The line searches of Newton's method.
#include <algorithm>
#include <cmath>
#include <utility>

#include "components/integrators/newton.h"

namespace stroma {

void Newton::move(NonlinearProblem& problem, double step) {
  const Rows u = problem.unknowns();
  copy(base_, u);
  problem.addTo(u, step, direction_);
  problem.unknownsChanged();
}

/// Makes the step that the line search accepts; residual_ and `now` become those of the new iterate. 0: none accepted, or
/// stopped; the iterate is unchanged.
double Newton::search(NonlinearProblem& problem, double& now) {
  const double slope = dot(residual_, direction_);
  if (!std::isfinite(slope)) return 0;
  copy(problem.unknowns(), base_);
  double step = problem.longestStep(direction_);
  if (settings.line_search_iterations > 0) {
    step = settings.use_energy && slope > 0 ? searchEnergy(problem, step, slope, now) : searchWork(problem, step, now);
  } else {
    move(problem, step);
    problem.residual(trial_);
    const double candidate = problem.sizeOf(trial_);
    if (std::isfinite(candidate))
      now = candidate;
    else
      step = 0;
  }
  if (step == 0) {
    move(problem, 0);
  } else {
    std::swap(residual_, trial_);
  }
  return step;
}

/// Of s R.d, by which a step s must decrease the energy. A whole correction decreases a parabola by half of that; one that goes beyond the
/// minimum and up again by next to nothing is refused, because the potential of damping is another one in the next iteration, which may
/// lead straight back.
static constexpr double least_decrease = 0.05;

/// Armijo: E(u + s d) <= E(u) - least_decrease s R.d. Where the difference drowns in the round-off of E, |R| decides.
double Newton::searchEnergy(NonlinearProblem& problem, double longest, double slope, double& now) {
  const double before = problem.energy();
  double step = longest, noise_of_positions = 0, refused = 0;
  for (int trial = 0; trial < settings.line_search_iterations && !stop_.isStopAsked(); ++trial) {
    move(problem, step);
    const double after = problem.energy();
    // the whole correction is refused: how far can rounded positions be to blame?
    if (trial == 1) noise_of_positions = problem.roundOff().energy;
    const double noise = 1e-13 * std::max(std::abs(before), std::abs(after)) + noise_of_positions;
    const bool enough = after <= before - least_decrease * step * slope;
    const bool drowned = step * slope <= noise;
    if (enough || drowned) {
      problem.residual(trial_);
      const double candidate = problem.sizeOf(trial_);
      if (std::isfinite(candidate) && (candidate < now || (enough && !drowned))) {
        now = candidate;
        return refused == 0 || drowned || !problem.mayMeetBarriers() ? step : lengthen(problem, step, refused, before, slope, now);
      }
      if (drowned) return 0;
    }
    refused = step;
    // the parabola through E(0), its slope and E(step)
    const double parabola = slope * step * step / (2 * (after - before + slope * step));
    const double longest = settings.line_search_coefficient * step;
    step = std::isfinite(parabola) ? std::clamp(parabola, std::min(0.1 * step, longest), longest) : 0.5 * longest;
  }
  return 0;
}

/// A step that leaves most of the slope is far too short: no parabola knows how fast a barrier's energy grows. Up to the step that
/// was refused lengths are tried whose ratio to both is the same. residual_ is asked for at the one that is returned, at last.
double Newton::lengthen(NonlinearProblem& problem, double step, double refused, double before, double slope, double& now) {
  constexpr double most_left = 0.5, least_ratio = 2;
  constexpr int most_trials = 3;
  bool is_there = true;
  for (int trial = 0; trial < most_trials && refused > least_ratio * step && dot(trial_, direction_) > most_left * slope; ++trial) {
    const double between = std::sqrt(step * refused);
    move(problem, between);
    is_there = problem.energy() <= before - least_decrease * between * slope;
    if (!is_there) {
      refused = between;
      continue;
    }
    problem.residual(trial_);
    is_there = std::isfinite(problem.sizeOf(trial_));
    if (!is_there) break;
    step = between, now = problem.sizeOf(trial_);
  }
  if (is_there) return step;
  move(problem, step);
  problem.residual(trial_);
  now = problem.sizeOf(trial_);
  return step;
}

/// A whole correction that leaves much of the slope ends far from the least energy along it: out of a barrier that has been pressed
/// close, each one but doubles the gap. The line goes on, twice as far each time.
void Newton::goOn(NonlinearProblem& problem, double slope, double& now) {
  constexpr double much_left = 0.3;
  constexpr int most_times = 4;
  for (int time = 0; time < most_times && now > goal() * scale_ && !stop_.isStopAsked(); ++time) {
    const double left = dot(residual_, direction_);
    if (!(slope > 0 && left > much_left * slope)) return;
    scale(2, direction_);
    slope = 2 * left;
    const double step = search(problem, now);
    if (step == 0) scale(0.5, direction_), problem.residual(residual_);  // derivatives are those of the last one
    if (step < 1) return;
  }
}

/// The next length after one that was refused. Where the work that it leaves says that it went far beyond what stopped it, as into
/// a wall, a tenth of it; where lengths have done so before, the root of the secant of the last two: the wall as both have felt it,
/// and not a place before it, where no derivative knows of it.
double Newton::shorter(double step, double left, double slope, Refused& before) const {
  constexpr double far = 0.01;  // of the step, where the secant from its beginning has its root
  const bool is_beyond = std::isfinite(left) && left * slope < 0;
  const bool is_far = is_beyond && std::abs(slope) < far * std::abs(left);
  double next = settings.line_search_coefficient * step;
  if (is_beyond && before.step > 0) {
    const double root = step - left * (before.step - step) / (before.left - left);
    if (root > 0 && root < step) next = root;
  } else if (is_far) {
    next = std::min(next, 0.1 * step);
  }
  before = is_far || (is_beyond && before.step > 0) ? Refused{step, left} : Refused{};
  return next;
}

/// Without an energy: |R(u + s d).d| <= 0.9 |R(u).d|, the criterion of Matthies and Strang 1979, or a smaller |R|. The
/// work along d plays the part of the energy's slope; |R| alone would reject good steps of a body that turns, whose
/// stiff directions are out of balance by the square of the rotation until the next iteration. Along a direction of negative curvature,
/// which a definite tangent can return, R.d grows while an energy would decrease.
double Newton::searchWork(NonlinearProblem& problem, double longest, double& now) {
  constexpr double most_growth = 4;
  const double slope = dot(residual_, direction_);
  double step = longest;
  Refused refused;
  const int trials = std::min(20, settings.line_search_iterations);
  for (int trial = 0; trial < trials && !stop_.isStopAsked(); ++trial) {
    move(problem, step);
    problem.residual(trial_);
    const double candidate = problem.sizeOf(trial_), left = dot(trial_, direction_);
    const bool is_enough = candidate <= (1 - 1e-4 * step) * now ||
                           std::abs(left) <= (longest < 1 ? 1 - 0.1 * step : 0.9) * std::abs(slope) ||
                           (is_replaced_ && slope > 0 && left > 0 && candidate <= most_growth * now);
    if (std::isfinite(candidate) && is_enough) {
      now = candidate;
      return step;
    }
    step = problem.mayMeetPenalties() ? shorter(step, left, slope, refused) : settings.line_search_coefficient * step;
  }
  return 0;
}

}  // namespace stroma
