// SPDX-License-Identifier: LGPL-2.1-or-later
// Position constraints of a system: corrections of x and v after the integrator's step.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "framework/simulation/integrator.h"
#include "framework/simulation/system.h"

namespace stroma {

namespace {

constexpr int most_sweeps = 1000;

/// Whether no number differs by more than round-off of the largest.
bool same(ConstRows now, ConstRows before) {
  double largest = 0, change = 0;
  for (std::size_t i = 0; i < now.doubles(); ++i) {
    largest = std::max(largest, std::abs(now.data[i]));
    change = std::max(change, std::abs(now.data[i] - before.data[i]));
  }
  return change <= 4 * std::numeric_limits<double>::epsilon() * largest;
}

/// correct(constraint) in turns until none was off by more than its tolerance, or a turn has changed nothing in `rows`
/// (a held node behind a plane: no further one would); the sweeps made, and the one that was off most. settle()
/// restores what the projective constraints say before each turn and after the last. `before` is memory for a copy.
struct Sweeps {
  int count = 0;
  double worst = 0;
  PositionConstraint* culprit = nullptr;  ///< the one with the worst violation
  /// The constraint that does not hold; null when all do.
  const PositionConstraint* broken() const { return worst > 1 ? culprit : nullptr; }
};
template <class Settle, class Correct>
Sweeps correctInTurns(const std::vector<PositionConstraint*>& constraints, ConstRows rows, Rows before, Settle&& settle,
                      Correct&& correct) {
  Sweeps sweeps;
  do {
    settle();
    // the first two turns end most steps
    if (sweeps.count > 2 && same(rows, before)) break;
    if (sweeps.count > 1) copy(rows, before);
    sweeps.worst = 0;
    for (PositionConstraint* constraint : constraints) {
      const double given = correct(*constraint);
      const double violation = std::isnan(given) ? std::numeric_limits<double>::infinity() : given;
      if (violation > sweeps.worst) sweeps.worst = violation, sweeps.culprit = constraint;
    }
    ++sweeps.count;
  } while (sweeps.worst > 1 && std::isfinite(sweeps.worst) && sweeps.count < most_sweeps);
  settle();
  return sweeps;
}

}  // namespace

void System::preparePositionConstraints() {
  if (position_constraints_.empty()) return;
  if (!integrator_.movesInTime())
    throw ComponentError(fmt::format("{} finds an equilibrium, and {} acts on motion", integrator_.path(),
                                     position_constraints_.front()->path()),
                         "an integrator of dynamics, or no position constraint");
  for (const PositionConstraint* constraint : position_constraints_)
    if (constraint->state().firstRow() >= independent_rows_)
      throw ComponentError(fmt::format("{} acts on {}, whose positions follow from another state by a mapping",
                                       constraint->path(), constraint->state().path()),
                           "position constraints on the state that is mapped from");
  mobility_.allocate(inverseLumpedMass());
  position_reference_.resize(independent_rows_);
  position_before_.resize(independent_rows_);
  for (PositionConstraint* constraint : position_constraints_) constraint->compile();
}

void System::enforcePositions(const StepContext& context, ConstRows x_start, StepReport& report) {
  const Rows x_now{x.rows().data, independent_rows_}, v_now{v.rows().data, independent_rows_};
  const PositionStep step{context.dt, context.t_end, {x_start.data, independent_rows_}, mobility_};
  copy(x_now, position_reference_);
  mobility_.reset(projectors_);
  for (PositionConstraint* constraint : position_constraints_) constraint->begin(step);
  const auto settle = [&](Rows tied) {
    groups_.average(tied);
    placePrescribed(context, x, v);
  };
  const Sweeps moved = correctInTurns(
      position_constraints_, x_now, position_before_, [&] { settle(x_now); },
      [&](PositionConstraint& constraint) { return constraint.correctPositions(step, x_now, position_reference_); });
  groups_.average(position_reference_);
  const double rate = 1 / context.dt;
  const double* reference = position_reference_.rows().data;
  for (std::size_t i = 0; i < v_now.doubles(); ++i) v_now.data[i] += rate * (x_now.data[i] - reference[i]);
  const Sweeps turned = correctInTurns(
      position_constraints_, v_now, position_before_, [&] { settle(v_now); },
      [&](PositionConstraint& constraint) { return constraint.correctVelocities(step, x_now, v_now); });
  applyMappings();
  report.constraint_sweeps += moved.count + turned.count;
  report.constraints_converged = !moved.broken() && !turned.broken();
  if (const PositionConstraint* culprit = moved.broken())
    report.constraint_reason =
        fmt::format("{} does not hold after {} corrections: {}", culprit->path(), moved.count, culprit->violation());
  else if (const PositionConstraint* turning = turned.broken())
    report.constraint_reason =
        fmt::format("velocities still break {} after {} corrections", turning->path(), turned.count);
}

}  // namespace stroma
