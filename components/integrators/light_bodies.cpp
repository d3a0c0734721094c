// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/integrators/light_bodies.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>

#include "components/integrators/exact_tangent.h"
#include "components/integrators/newton.h"

namespace stroma {

void LightBodies::compile(System& system) {
  system_ = &system;
  bodies_.clear(), in_focus_ = nullptr;
  for (const State* state : system.states())
    if (state->firstRow() < system.independentRows() && state->size() > 0) bodies_.push_back({state, state->firstRow(), state->size()});
  if (bodies_.size() < 2) bodies_.clear();
}

void LightBodies::begin(ConstRows residual, double weight) {
  for (Body& body : bodies_) {
    body.is_done = false;
    body.scale = std::max(norm(residual.segment(body.first, body.count)), weight * norm(system_->f.rows().segment(body.first, body.count)));
  }
}

bool LightBodies::focus(ConstRows residual, double tolerance, double weight, SystemMatrix& tangent, double displacement) {
  constexpr double least = 1e-2, looser = 1e3, round_off = 1e-9;
  const double share = std::max(least, looser * tolerance);
  const auto left = [&](const Body& body) { return body.is_done ? 0 : norm(residual.segment(body.first, body.count)); };
  const auto isOut = [&](const Body& body) { return left(body) > share * body.scale; };
  if (std::ranges::none_of(bodies_, isOut)) return false;
  if (loads_.count() != system_->allRows()) loads_.resize(system_->allRows());
  clear(loads_);
  for (const Mass* mass : system_->masses()) mass->addGravity(loads_);
  for (ForceField* field : system_->forceFields())
    if (!field->traits().has_stiffness) field->addForce(system_->x, system_->v, loads_);
  for (Body& body : bodies_) body.scale = std::max(body.scale, weight * norm(loads_.rows().segment(body.first, body.count)));
  std::vector<double> blocks;
  if (std::ranges::any_of(bodies_, isOut)) tangent.diagonalBlocks(blocks);
  const auto isSeen = [&](const Body& body) {
    double way = 0, place = 0;
    for (Index row = body.first; row < body.first + body.count; ++row) {
      const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> d(blocks.data() + std::size_t(row) * 9);
      if (const Vec3 moves = d.inverse() * Vec3(residual[row]); moves.allFinite()) way = std::max(way, moves.norm());
      place = std::max(place, Vec3(system_->x[row]).norm());
    }
    return displacement * way > round_off * place;
  };
  for (Body& body : bodies_) {
    if (!isOut(body) || !isSeen(body)) continue;
    if (!in_focus_ || left(body) * in_focus_->scale > left(*in_focus_) * body.scale) in_focus_ = &body;
  }
  if (in_focus_) in_focus_->is_done = true;
  return in_focus_ != nullptr;
}

void LightBodies::narrow(Rows residual) const {
  if (!in_focus_) return;
  clear(residual.segment(0, in_focus_->first));
  const Index end = in_focus_->first + in_focus_->count;
  clear(residual.segment(end, residual.count - end));
}

/// Of a solve that starts with this |R|.
void Newton::takeScale(NonlinearProblem& problem, double now) {
  scale_ = std::isfinite(now) ? std::max(now, problem.loadScale()) : 0;
  if (LightBodies* const bodies = problem.lightBodies()) bodies->begin(residual_, problem.weightOfForces());
}

/// And then for bodies that are out of balance by themselves, one after the other.
StepReport Newton::solveAll(NonlinearProblem& problem, LinearSolver& solver) {
  constexpr double attained = 1e-6;  // where a body's own round-off has not been asked for
  StepReport report = solveFixed(problem, solver);
  const bool is_relative = settings.absolute_residual == 0 && settings.successive_residual == 0 && !settings.fixed_count && enough_ == 0;
  LightBodies* const bodies = problem.lightBodies();
  if (!bodies || !is_relative || was_slow_) return report;
  const auto goesOn = [&] {
    if (!report.newton_converged || report.failed() || report.stopped) return false;
    const double weight = problem.weightOfForces(), displacement = problem.displacementPerUnknown();
    return bodies->focus(residual_, settings.relative_residual, weight, problem.tangent(), displacement);
  };
  const NewtonSettings whole = settings;
  while (goesOn()) {
    settings.use_energy = settings.leaves_slow = false;
    settings.relative_residual = std::max(whole.relative_residual, attained);
    in_focus_ = keeps_scale_ = true, scale_ = bodies->scale();
    const StepReport before = report;
    report = solveFixed(problem, solver);
    addCounts(before, report);
    if (!report.newton_converged) report.reason += fmt::format(", of {} by itself beside heavier bodies", bodies->body().path());
    settings = whole, in_focus_ = false;
    bodies->end();
    problem.residual(residual_);
  }
  return report;
}

}  // namespace stroma
