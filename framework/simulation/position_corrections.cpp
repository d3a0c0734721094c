// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/simulation/position_corrections.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "framework/scene/spans.h"
#include "framework/simulation/refusals.h"

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
      const Span span("correct", constraint);
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

void PositionCorrections::compile(const Actors& actors, const Integrator& integrator, ConstraintSet& constraints) {
  actors_ = &actors;
  constraints_ = &constraints;
  if (empty()) return;
  checkPositionConstraints(actors, integrator, constraints);
  mobility_.allocate(constraints.inverseLumpedMass());
  reference_.resize(actors.independent_rows);
  before_.resize(actors.independent_rows);
  for (PositionConstraint* constraint : actors.position_constraints) constraint->compile();
}

void PositionCorrections::enforce(const StepContext& context, ConstRows x_start, Rows x, Rows v, StepReport& report) {
  const Index rows = actors_->independent_rows;
  const Rows x_now = x.head(rows), v_now = v.head(rows);
  const PositionStep step{context.dt, context.t_end, x_start.head(rows), mobility_};
  copy(x_now, reference_);
  mobility_.reset(constraints_->projectors());
  for (PositionConstraint* constraint : actors_->position_constraints) constraint->begin(step);
  const auto settle = [&] { constraints_->placePrescribed(context, x, v); };
  const Sweeps moved = correctInTurns(
      actors_->position_constraints, x_now, before_, [&] { constraints_->groups().averagePositions(actors_->motion, x_now), settle(); },
      [&](PositionConstraint& constraint) { return constraint.correctPositions(step, x_now, reference_); });
  constraints_->groups().averagePositions(actors_->motion, reference_);
  actors_->motion.difference(x_now, reference_);
  axpy(1 / context.dt, reference_, v_now);
  const Sweeps turned = correctInTurns(
      actors_->position_constraints, v_now, before_, [&] { constraints_->groups().average(v_now), settle(); },
      [&](PositionConstraint& constraint) { return constraint.correctVelocities(step, x_now, v_now); });
  report.constraint_sweeps += moved.count + turned.count;
  report.constraints_converged = !moved.broken() && !turned.broken();
  if (const PositionConstraint* culprit = moved.broken())
    report.constraint_reason =
        fmt::format("{} is violated after {} corrections: {}", culprit->path(), moved.count, culprit->violation());
  else if (const PositionConstraint* turning = turned.broken())
    report.constraint_reason = fmt::format("velocities still violate {} after {} corrections", turning->path(), turned.count);
}

}  // namespace stroma
