// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/integrators/light_bodies.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "components/integrators/exact_tangent.h"
#include "components/integrators/newton.h"
#include "components/integrators/whole_matrix.h"

namespace stroma {

/// Of S_b, by which a body is in balance: alone, and where forces of constraint are found with it.
static double boundAlone(double tolerance) { return std::max(1e-2, 1e3 * tolerance); }
static double boundWithConditions(double tolerance) { return std::max(1e-5, 1e3 * tolerance); }

void LightBodies::compile(System& system) {
  system_ = &system;
  bodies_.clear(), in_focus_ = nullptr;
  for (const State* state : system.states())
    if (state->firstRow() < system.independentRows() && state->size() > 0) bodies_.push_back({state, state->firstRow(), state->size()});
  if (bodies_.size() < 2) bodies_.clear();
}

void LightBodies::begin(ConstRows residual, double weight) {
  in_focus_ = nullptr;
  for (Body& body : bodies_) {
    body.is_done = body.is_found = false, body.carried = 0;
    body.scale = std::max(norm(residual.segment(body.first, body.count)), weight * norm(system_->f.rows().segment(body.first, body.count)));
  }
}

bool LightBodies::focus(ConstRows residual, double tolerance, double weight, SystemMatrix& tangent, double displacement) {
  find(residual, boundAlone(tolerance), weight, tangent, displacement);
  if (in_focus_) in_focus_->is_done = true;
  return in_focus_ != nullptr;
}

const State* LightBodies::outOfBalance(ConstRows residual, ConstRows carried, double tolerance, double weight, SystemMatrix& tangent,
                                       double displacement) {
  for (Body& body : bodies_) body.carried = norm(carried.segment(body.first, body.count));
  find(residual, boundWithConditions(tolerance), weight, tangent, displacement);
  const Body* const found = std::exchange(in_focus_, nullptr);
  return found ? found->state : nullptr;
}

std::size_t LightBodies::found() const { return std::size_t(std::ranges::count_if(bodies_, &Body::is_found)); }

double LightBodies::left(ConstRows residual) const {
  double sum = 0;
  for (const Body& body : bodies_)
    if (body.is_found && body.size() > 0) sum += std::pow(norm(residual.segment(body.first, body.count)) / body.size(), 2);
  return std::sqrt(sum);
}

bool LightBodies::areLittle(ConstRows residual, double tolerance) const {
  return std::ranges::none_of(bodies_, [&](const Body& body) {
    return body.is_found && norm(residual.segment(body.first, body.count)) > boundWithConditions(tolerance) * body.size();
  });
}

void LightBodies::find(ConstRows residual, double share, double weight, SystemMatrix& tangent, double displacement) {
  constexpr double round_off = 1e-9;
  const auto left = [&](const Body& body) { return body.is_done ? 0 : norm(residual.segment(body.first, body.count)); };
  const auto isOut = [&](const Body& body) { return left(body) > share * body.size(); };
  if (std::ranges::none_of(bodies_, isOut)) return;
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
    body.is_found = true;
    if (!in_focus_ || left(body) * in_focus_->size() > left(*in_focus_) * body.size()) in_focus_ = &body;
  }
}

void LightBodies::narrow(Rows residual) const {
  if (!in_focus_) return;
  clear(residual.segment(0, in_focus_->first));
  const Index end = in_focus_->first + in_focus_->count;
  clear(residual.segment(end, residual.count - end));
}

void solveLightBodies(const System& system, LinearSolver& solver, SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms,
                      StepReport& report) {
  constexpr double far = 10, round_off = 1e-6;
  const double little = std::max(round_off, far * report.linear_residual), left = report.linear_residual * norm(b);
  Vector residual, correction;
  for (const State* state : system.states()) {
    const Index first = state->firstRow(), count = state->size();
    if (first >= b.count || count == 0) continue;
    const double own = norm(b.segment(first, count));
    if (own == 0 || left <= little * own) continue;
    residual.resize(b.count), correction.resize(b.count);
    matrix.multiply(x, residual);
    scale(-1, residual), axpy(1, b, residual);
    if (norm(residual.rows().segment(first, count)) <= little * own) continue;
    clear(residual.rows().segment(0, first));
    clear(residual.rows().segment(first + count, b.count - first - count));
    clear(correction);
    const SolveReport solve = solveWhole(solver, matrix, residual, correction, terms);
    report.linear_iterations += solve.iterations;
    report.stopped = report.stopped || solve.stop == SolveStop::stopped;
    if (!solve.usable()) return;
    report.linear_converged = report.linear_converged && solve.stop == SolveStop::converged;
    report.linear_at_limit = report.linear_at_limit || solve.stop == SolveStop::iteration_limit || solve.stop == SolveStop::stagnated;
    axpy(1, correction, x);
  }
}

/// Of a solve that starts with this |R|.
void Newton::takeScale(NonlinearProblem& problem, double now) {
  scale_ = std::isfinite(now) ? std::max(now, problem.loadScale()) : 0;
  if (LightBodies* const bodies = problem.lightBodies()) bodies->begin(residual_, problem.weightOfForces());
}

/// The settings and the scale with which a body is solved by itself, for as long as this lives. A force may throw meanwhile, and its
/// caller go on: what is of all bodies is put back then, too.
class Newton::Focus {
 public:
  Focus(Newton& newton, LightBodies& bodies) : newton_(newton), bodies_(bodies), settings_(newton.settings), scale_(newton.scale_) {
    constexpr double attained = 1e-6;  // where a body's own round-off has not been asked for
    newton.settings.use_energy = newton.settings.leaves_slow = false;
    newton.settings.relative_residual = std::max(settings_.relative_residual, attained);
    newton.in_focus_ = newton.keeps_scale_ = true, newton.scale_ = bodies.scale();
  }
  ~Focus() {
    newton_.settings = settings_, newton_.scale_ = scale_, newton_.in_focus_ = newton_.keeps_scale_ = false;
    bodies_.end();
  }
  Focus(const Focus&) = delete;
  Focus& operator=(const Focus&) = delete;

 private:
  Newton& newton_;
  LightBodies& bodies_;
  const NewtonSettings settings_;
  const double scale_;
};

/// One body, and then all of them once more where its way has left their |R| above where they were solved to.
void Newton::solveBody(NonlinearProblem& problem, LinearSolver& solver, LightBodies& bodies, StepReport& report) {
  const double enough = std::max(goal() * scale_, problem.sizeOf(residual_));
  const std::string name = bodies.body().path();
  const auto solveOn = [&] {
    const StepReport before = report;
    report = solveFixed(problem, solver);
    addCounts(before, report);
  };
  {
    const Focus focus(*this, bodies);
    solveOn();
  }
  if (!report.newton_converged) report.reason += fmt::format(", of {} by itself beside heavier bodies", name);
  problem.residual(residual_);
  if (!report.newton_converged || report.failed()) return;
  const double now = problem.sizeOf(residual_);
  if (now <= enough) return void(report.newton_residual = scale_ > 0 ? now / scale_ : now);
  struct Once {
    bool& keeps;
    ~Once() { keeps = false; }
  } const once{keeps_scale_ = true};
  solveOn();
  if (!report.newton_converged) report.reason += fmt::format(", of all bodies after {} was solved by itself", name);
}

/// And then for bodies that are out of balance by themselves, one after the other.
StepReport Newton::solveAll(NonlinearProblem& problem, LinearSolver& solver) {
  StepReport report = solveFixed(problem, solver);
  const bool is_relative = settings.absolute_residual == 0 && settings.successive_residual == 0 && !settings.fixed_count && enough_ == 0;
  LightBodies* const bodies = problem.lightBodies();
  if (!bodies || !is_relative || was_slow_) return report;
  const auto goesOn = [&] {
    if (!report.newton_converged || report.failed()) return false;
    const double weight = problem.weightOfForces(), displacement = problem.displacementPerUnknown();
    return bodies->focus(residual_, settings.relative_residual, weight, problem.tangent(), displacement);
  };
  while (goesOn()) solveBody(problem, solver, *bodies, report);
  return report;
}

}  // namespace stroma
