// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/integrators/multipliers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "components/integrators/uncoupled_constraint_correction.h"
#include "components/integrators/whole_matrix.h"
#include "framework/mechanics/condition_roles.h"
#include "framework/simulation/step_watch.h"

namespace stroma {

void Multipliers::declare(DataTable& table) {
  table.add("conditionIterations", iterations_).help("steps of the search for forces of Lagrangian constraints, in the last step").output();
  table.add("conditionResidual", residual_)
      .help("by how much the worst law of such a force does not hold where that search ended, against the largest that does not hold "
            "without forces")
      .unit("-")
      .output();
  table.add("conditionBudget", budget_)
      .help("most that this search may cost in a step, as eliminations of a thousand rows; beyond it the step has failed")
      .unit("-")
      .min(0, false);
}

void Multipliers::compile(System& system) {
  system_ = &system;
  if (empty()) return;
  for (Vector* vector : {&start_, &work_}) vector->resize(system.allRows());
  for (Vector* vector : {&right_side_, &whole_, &before_, &free_, &base_, &directions_at_, &here_})
    vector->resize(system.independentRows());
  carried_.resize(system.independentRows());
  uncoupled_ = findUncoupled();
  if (!uncoupled_.empty()) pushes_.resize(system.independentRows());
  sweeps_ = findSweeps();
  bodies_.compile(system);
}

void Multipliers::begin(const Rule& rule, bool carries) {
  if (empty()) return;
  rule_ = rule;
  carries_ = carries;
  made_before_ = iterationsOfAll(), searches_before_ = solve_.searches;
  if (!carries)
    for (UncoupledConstraintCorrection* each : uncoupled_) each->takeMasses(*system_);
  knows_forces_ = has_changed_ = false, times_left_ = 0, bends_.clear();
  redundant_.forget(), is_of_bodies_ = false;
  spent_ = 0, is_swept_ = false, sweeping_ = swept_;
  carried_.begin(rule.weight);
  copy(system_->mappingChain().positions(system_->x), start_);
  if (rule.old_share == 0) return;
  findConditions();
  if (rule.has_velocities) {
    const ConstRows moves = system_->mappingChain().direction(system_->independent(system_->v));
    start_speeds_.resize(rows_.rows().size());
    for (std::size_t i = 0; i < start_speeds_.size(); ++i) start_speeds_[i] = along(i, moves);
  }
  start_directions_.resize(std::max(start_directions_.size(), rows_.rows().size()));
  for (std::size_t i = 0; i < rows_.rows().size(); ++i) {
    Vector& direction = start_directions_[i];
    if (direction.count() != system_->independentRows()) direction.resize(system_->independentRows());
    pullBack(i, direction);
  }
}

void Multipliers::findConditions() {
  std::swap(rows_, old_rows_);
  rows_.clear(), ends_.clear();
  const ConstRows x = system_->mappingChain().positions(system_->x);
  for (const LagrangianConstraint* constraint : system_->actors().lagrangian_constraints) {
    constraint->addConditions(x, start_, rows_);
    ends_.push_back(rows_.rows().size());
  }
  if (violation_share_ < 1 && way_.size() == rows_.rows().size()) subtractInitialViolation();
  solve_.g.resize(Eigen::Index(rows_.rows().size()));
  solve_.sizes.resize(rows_.rows().size());
  for (std::size_t i = 0; i < rows_.rows().size(); ++i) {
    solve_.g[Eigen::Index(i)] = rows_.rows()[i].value;
    double sum = 0;
    for (const auto& entry : rows_.entriesOf(rows_.rows()[i])) sum += entry.gradient.squaredNorm();
    solve_.sizes[i] = std::sqrt(sum);
  }
}

/// Its force is zero, so that nothing answers to it: the condition of what has not come near in this step.
bool Multipliers::isIdle(std::size_t row) const {
  return rows_.rows()[row].kind == LagrangianRows::Kind::given && rows_.rows()[row].factor == 0;
}

void Multipliers::request(ConstRows right_side, Vector& response) {
  if (response.count() != system_->independentRows()) response.resize(system_->independentRows());
  clear(response);
  requested_.push_back(right_side), solutions_.push_back(response);
}

/// A^-1 of right_side_.
bool Multipliers::answer(LinearSolver& solver, SystemMatrix& matrix, Vector& response, StopToken stop, StepReport& report) {
  requested_.clear(), solutions_.clear();
  request(right_side_, response);
  return solveRequested(solver, matrix, stop, report);
}

/// A^-1 of all that is asked for.
bool Multipliers::solveRequested(LinearSolver& solver, SystemMatrix& matrix, StopToken stop, StepReport& report) {
  const SolveReport solve = uncoupled_.empty() || carries_ ? solveWhole(solver, matrix, requested_, solutions_, {.stop = stop})
                                                           : solveInTurn(solver, matrix, stop);
  report.linear_iterations += solve.iterations;
  report.factorisations += solve.factored;
  report.stopped = report.stopped || solve.stop == SolveStop::stopped;
  if (report.stopped) return false;
  if (!solve.usable() || solve.stop == SolveStop::breakdown) {
    report.diverged = true;
    report.reason = fmt::format("the linear solver {} {} for a force of constraint{}", solver.path(), describe(solve.stop),
                                solve.stop != SolveStop::not_definite ? ""
                                    : ": without these forces a body is unstable, as one that is pressed. EigenSparseLU solves for it, or "
                                      "AttachProjectiveConstraint holds it in the matrix");
    return false;
  }
  report.linear_at_limit =
      report.linear_at_limit || solve.stop == SolveStop::iteration_limit || solve.stop == SolveStop::stagnated;
  report.linear_converged =
      report.linear_converged && (solve.stop == SolveStop::converged || solve.stop == SolveStop::zero_right_side);
  for (const Rows& each : solutions_) system_->constraints().project(each);
  return true;
}

/// Where the search of a correction begins.
void Multipliers::guessForces() {
  const std::size_t count = rows_.rows().size();
  solve_.l.setZero(Eigen::Index(count)), solve_.contradiction = 0;
  yields_.clear();
  std::size_t begin = 0;
  const auto& constraints = system_->actors().lagrangian_constraints;
  for (std::size_t i = 0; i < constraints.size(); begin = ends_[i++]) {
    const auto* shares = dynamic_cast<const GuessesForces*>(constraints[i]);
    if (!shares) continue;
    yields_.resize(count, 0);
    shares->guessForces({solve_.l.data() + begin, ends_[i] - begin}, {yields_.data() + begin, ends_[i] - begin});
  }
  if (std::ranges::none_of(yields_, [](double each) { return each > 0; })) yields_.clear();
}

RedundantForces::Problem Multipliers::problemWith(const BodyRows* bodies, double budget) const {
  constexpr double at_rest = 1e-6;  // of what is tolerated: by less than that forces of the step before need not be off
  return {.rows = rows_.rows(), .live = live_, .w = solve_.w, .g = solve_.g, .sizes = solve_.sizes, .yields = yields_, .allowed = allowed_,
          .at_rest = carries_ ? at_rest : 0, .goes_on = solve_.searches > searches_before_, .is_repeated = !carries_ && !isOnce(),
          .budget = budget, .bodies = bodies, .factor = rule_.weight * rule_.displacement};
}

void Multipliers::findForces(StopToken stop) {
  if (sweepForces(stop)) return;
  constexpr double of_thousand_rows = 1e9;
  solve_.enough = 0;
  const double budget = budget_ * of_thousand_rows;
  const auto findRedundant = [&](const BodyRows* bodies) {
    const bool is_found = redundant_.find(problemWith(bodies, budget - spent_), solve_.l, stop);
    if (is_found) solve_.contradiction = redundant_.contradiction(), solve_.enough = redundant_.unsettled();
    spent_ += redundant_.spent, is_spent_ = spent_ > budget;
    return is_found;
  };
  if (makesMotionAlone()) {
    if (findRedundant(&bodies_)) {
      ++solve_.searches;
      return;
    }
    is_without_w_ = false, bodies_.couple(rule_.weight * rule_.displacement, solve_.w);
  }
  if (!yields_.empty()) findRedundant(nullptr);
  if (spent_ <= budget) {
    solve_.spent = 0, solve_.budget = budget - spent_;
    solve_.solve(rows_.rows(), stop, allowed_);
    spent_ += solve_.spent;
  }
  is_spent_ = spent_ > budget;
}

void Multipliers::give() {
  iterations_ = int(iterationsOfAll() - made_before_);
  residual_ = rows_.rows().empty() || solve_.searches == searches_before_ ? 0
              : makesMotionAlone()                                              ? redundant_.unsettled()
                                                                                : solve_.unsettled();
  std::size_t begin = 0;
  const auto& constraints = system_->actors().lagrangian_constraints;
  for (std::size_t i = 0; i < constraints.size(); begin = ends_[i++])
    constraints[i]->takeForces({solve_.l.data() + begin, ends_[i] - begin});
}

/// Which conditions there are may depend on the forces that have been found; of those that share forces see changeDirections().
bool Multipliers::changeConditions() {
  const ConstRows x = system_->mappingChain().positions(system_->x);
  asked_to_change_ = system_->actors().lagrangian_constraints;
  for (LagrangianConstraint*& each : asked_to_change_)
    if (dynamic_cast<const GuessesForces*>(each)) each = nullptr;
  if (!ChangesConditions::changeAny(asked_to_change_, ends_, x, solve_.l.data(), own_.data())) return false;
  --changes_left_, has_changed_ = true;
  return true;
}

/// As those of cables and cavities.
bool Multipliers::areFewAndSmooth() const {
  constexpr std::size_t few = 8;
  const auto rubs = [](const LagrangianRows::Row& row) { return row.kind == LagrangianRows::Kind::rub; };
  return rows_.rows().size() <= few && std::ranges::none_of(rows_.rows(), rubs);
}

/// What the forces change u by.
void Multipliers::sumResponses() {
  copy(whole_, before_);
  clear(whole_);
  if (is_of_bodies_) {
    for (std::size_t k = 0; k < live_.size(); ++k)
      if (const double p = rule_.weight * solve_.l[Eigen::Index(live_[k])]; p != 0) bodies_.rows()[k].move(p, whole_.rows().data);
    return;
  }
  if (carries_) axpy(-1, base_, whole_);
  for (Eigen::Index i = 0; i < solve_.l.size(); ++i)
    if (const double p = rule_.weight * solve_.l[i]; p != 0) axpy(p, responses_[std::size_t(i)], whole_);
}

/// x and v from those without forces of constraint, with whole_ in the place of before_.
void Multipliers::apply(Rows change) {
  System& s = *system_;
  axpy(1, whole_, change), axpy(-1, before_, change);
  if (rule_.has_velocities) axpy(1, whole_, s.independent(s.v)), axpy(-1, before_, s.independent(s.v));
  copy(free_, s.independent(s.x));
  s.motion().advance(rule_.displacement, whole_, s.independent(s.x));
}

/// base_ = what the carried impulses do, with the matrix that has the turning of gradients. False: a solve gave nothing.
bool Multipliers::solveForCarried(LinearSolver& solver, SystemMatrix& matrix, ConstRows direction, StopToken stop, StepReport& report) {
  copy(carried_.now(), right_side_);
  system_->constraints().project(right_side_);
  if (!answer(solver, matrix, base_, stop, report) || !respondToBends(solver, matrix, stop, report)) return false;
  if (!bends_.empty()) {  // d - (d - base) less what bends take of it
    axpy(-1, direction, base_);
    bends_.takeFrom(base_);
    axpy(1, direction, base_);
  }
  return true;
}

/// g as it would be without the forces of the last round.
void Multipliers::leaveOutForces() {
  copy(whole_, before_);
  if (carries_) axpy(1, base_, before_);
  if (is_of_bodies_) {
    const double* const motion = before_.rows().data;
    for (std::size_t k = 0; k < live_.size(); ++k) solve_.g[Eigen::Index(live_[k])] -= rule_.displacement * bodies_.rows()[k].along(motion);
    return;
  }
  if (keepsDirections()) {
    for (const std::size_t row : live_) solve_.g[Eigen::Index(row)] -= rule_.displacement * dot(directions_[row], before_);
    return;
  }
  const ConstRows along = system_->mappingChain().direction(before_);
  for (Eigen::Index i = 0; i < solve_.g.size(); ++i)
    for (const auto& [row, gradient] : rows_.entriesOf(rows_.rows()[std::size_t(i)]))
      solve_.g[i] -= rule_.displacement * gradient.dot(along[row]);
}

/// Directions, what they move and W, as far as they are others than a round before. False: a solve gave nothing.
bool Multipliers::prepareRound(bool is_first, LinearSolver& solver, SystemMatrix& matrix, StopToken stop, StepReport& report) {
  const bool follows_turns = !system_->mappingChain().isLinear();  // as mapped points do
  if (!is_first && !follows_turns && rows_.hasGradientsOf(old_rows_)) return true;
  if (!takeBodyRows(is_first, solver, matrix, stop, report)) return false;
  if (is_of_bodies_) return true;
  if (is_first || (!carries_ && !keeps_ && follows_turns))
    is_answered_.clear();
  else if (!carries_)
    forgetChanged();
  if (!carries_) takeDirections();
  if (!respond(solver, matrix, stop, report)) return false;
  couple();
  return true;
}

void Multipliers::correct(LinearSolver& solver, SystemMatrix& matrix, Rows change, ConstRows direction, StopToken stop,
                          StepReport& report) {
  constexpr int most_rounds = 100, most_idle = 10, few_idle = 2, few_left = 3;
  constexpr double close = 1e-13, far_less = 1e-3;  // of the place; of what is tolerated
  System& s = *system_;
  copy(s.independent(s.x), free_), clear(whole_);
  bool is_mixed = is_left_ = false;
  changes_left_ = most_changes, mixing_.restart(), keeps_ = false, kept_since_ = 0, keeps_directions_.clear();
  if (carries_ && !solveForCarried(solver, matrix, direction, stop, report)) return;
  double step = 0, least = std::numeric_limits<double>::infinity();  // of the steps that were half of all before them
  double size = largest(s.independent(s.x)) + rule_.displacement * largest(change);
  // what forces of constraint take back of the free motion leaves its last digits, also where a body stands at the origin
  const double rounding = 16 * std::numeric_limits<double>::epsilon() * size;
  for (int round = 0, least_round = 0; round < most_rounds; ++round) {
    if (report.stopped = report.stopped || stop.isStopAsked(); report.stopped) return;
    findConditions();
    if (conditionsHold(round, step)) break;
    if (round == 0 && stepWatch()) stepWatch()->constraintGradients(s, rows_, rule_.displacement);
    if (rows_.rows().empty() && !carries_) break;
    if (round == 0) guessForces();
    if (!prepareRound(round == 0, solver, matrix, stop, report)) return;
    leaveOutForces();
    last_forces_ = solve_.l;
    const double little = far_less * leastTolerance(false);  // finds what each row may be off by, which the search asks for
    findForces(stop);
    report.stopped = report.stopped || stop.isStopAsked();
    if (report.stopped || isSpent(report)) return;
    sumResponses();
    const double last = step;
    step = rule_.displacement * distance(whole_, before_);
    if (round > 0 && step > 0.5 * last && carries_ && areFewAndSmooth()) {
      // along these directions no force may do it, as of a cable that bends much: Newton's method goes on from the linear answer
      solve_.l = last_forces_, is_left_ = true, step = last;
      break;
    }
    // two places that share a force may pass it to and fro for ever, by round-off of their directions
    if (!(step > 0.5 * least)) least = step, least_round = round;
    const int idle = round - least_round;
    const bool is_idle = (isNoise(step) && redundant_.areInitialGuess()) || (step <= held_within * size && idle > most_idle) ||
                         (step <= little && idle > few_idle);
    is_left_ = !is_idle && idle > few_left && step > little && mayLeaveDirections();
    const bool goes_on = std::isfinite(step) && step > close * size + rounding && !is_idle && !is_left_;
    // forces that turn much in a step swing; directions of few that nothing rubs are found by a few mixed iterates, but noise is not mixed
    is_mixed = is_mixed || (round > 3 && step > 0.5 * last) || (round > 0 && !carries_ && areFewAndSmooth());
    if (goes_on && is_mixed && !keeps_ && !isNoise(step) && round + 1 < most_rounds) mixing_.next(before_, whole_);
    apply(change);
    size = largest(s.independent(s.x)) + rule_.displacement * largest(change);
    const bool is_last = round + 1 == most_rounds;
    if (goes_on && !isOnce() && !is_last) continue;
    if (is_left_ || !std::isfinite(step) || !changeConditions()) break;
    mixing_.restart(), least = std::numeric_limits<double>::infinity(), is_left_ = carries_;
    if (is_last) changes_left_ = 0;
    if (is_left_ || changes_left_ == 0) break;
    round = least_round = 0, is_mixed = false;
  }
  findConditions();
  solve_.l.conservativeResizeLike(Eigen::VectorXd::Zero(solve_.g.size())), own_.resize(rows_.rows().size(), 0);
  knows_forces_ = true, give();
  judge(step, size, rounding, report);
}

}  // namespace stroma
