// SPDX-License-Identifier: LGPL-2.1-or-later
// Of the forces of constraint: the directions J^T along which they act (multipliers.h).
#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <vector>

#include "components/integrators/multipliers.h"
#include "framework/mechanics/condition_roles.h"
#include "framework/simulation/integrator.h"

namespace stroma {

/// 1 or -1 when the gradient is that of the row before, or its opposite; else 0.
double Multipliers::signAgainstPreviousRow(std::size_t row) const {
  if (row == 0 || rule_.old_share != 0 || isIdle(row - 1)) return 0;
  const auto a = rows_.entriesOf(rows_.rows()[row - 1]), b = rows_.entriesOf(rows_.rows()[row]);
  for (const double sign : {1.0, -1.0})
    if (std::equal(a.begin(), a.end(), b.begin(), b.end(),
                   [sign](const auto& p, const auto& q) { return p.row == q.row && p.gradient == sign * q.gradient; }))
      return sign;
  return 0;
}

/// J^T of one row on what may move.
void Multipliers::pullBack(std::span<const LagrangianRows::Entry> entries, Rows out) {
  clear(work_);
  for (const auto& [at, gradient] : entries) work_[at] += gradient;
  system_->mappingChain().pullBack(work_);
  copy(system_->independent(work_), out);
  system_->constraints().project(out);
}

void Multipliers::takeDirection(std::size_t row) {
  has_direction_[row] = true;
  Vector& direction = directions_[row];
  if (direction.count() != system_->independentRows()) direction.resize(system_->independentRows());
  like_[row] = row > 0 && has_direction_[row - 1] ? signAgainstPreviousRow(row) : 0;
  if (like_[row] != 0) {
    copy(directions_[row - 1], direction);
    scale(like_[row], direction);
    return;
  }
  pullBack(row, direction);
  if (rule_.old_share == 0) return;
  scale(1 - rule_.old_share, direction);
  axpy(rule_.old_share, start_directions_[row], direction);
}

/// Rows with the gradients that they had a round before keep what answers to them. What they turn with moves on.
void Multipliers::forgetChanged() {
  const auto &rows = rows_.rows(), &old = old_rows_.rows();
  const bool stands = system_->mappingChain().isLinear();
  is_answered_.resize(rows.size(), false);
  std::size_t constraint = 0;
  bool keeps = stands;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const bool is_first = i == 0 || i >= ends_[constraint];
    while (i >= ends_[constraint]) ++constraint;
    if (is_first) keeps = stands || dynamic_cast<const GuessesForces*>(system_->actors().lagrangian_constraints[constraint]);
    const auto now = rows_.entriesOf(rows[i]);
    if (!keeps || rows.size() != old.size() || !std::ranges::equal(now, old_rows_.entriesOf(old[i]))) is_answered_[i] = false;
  }
}

/// Where directions of constraints that share forces turn to and fro they stay, those of each that is violated. Where that does not
/// lead to an end all are released, to stay from another place on. True: either begins here.
bool Multipliers::keepDirections(int round) {
  constexpr int few = 2, many = 20, most = 25;
  kept_since_ = std::min(kept_since_, round);
  if (carries_ || yields_.empty()) return false;
  const int since = round - kept_since_;
  const bool releases = keeps_ && since >= most;
  if (!releases && since < (redundant_.areSwept() ? few : many)) return false;
  if (!changeDirections(releases)) return false;
  keeps_ = !releases, kept_since_ = round;
  return true;
}

/// Of those that keep their directions, or of all others. True: one has changed them.
bool Multipliers::changeDirections(bool releases) {
  const ConstRows x = system_->mappingChain().positions(system_->x);
  const auto& constraints = system_->actors().lagrangian_constraints;
  bool have_changed = false;
  keeps_directions_.resize(constraints.size(), false);
  for (std::size_t i = 0, begin = 0; i < constraints.size(); begin = ends_[i++]) {
    auto* const changes = dynamic_cast<ChangesConditions*>(constraints[i]);
    if (!changes || !dynamic_cast<const GuessesForces*>(constraints[i]) || bool(keeps_directions_[i]) != releases) continue;
    const std::size_t count = ends_[i] - begin;
    if (!changes->changeConditions(x, {solve_.l.data() + begin, count}, {own_.data() + begin, count})) continue;
    keeps_directions_[i] = !releases, have_changed = true;
  }
  return have_changed;
}

/// J^T of rows that may have a force, where they were found: they are few of those that may come near in a step.
void Multipliers::takeDirections() {
  const std::size_t count = rows_.rows().size();
  directions_.resize(std::max(directions_.size(), count));
  like_.assign(count, 0), has_direction_.assign(count, false);
  if (carries_) is_answered_.clear();
  for (std::size_t i = 0; i < count; ++i)
    if (i < is_answered_.size() && is_answered_[i])
      has_direction_[i] = true;
    else if (!isIdle(i))
      takeDirection(i);
  if (carries_) copy(system_->independent(system_->x), directions_at_);
}

/// What has come near since directions were taken gets its own from there.
void Multipliers::computeNewDirections() {
  constexpr int most = 8;  // of times that going back there brings others near
  const Rows x = system_->independent(system_->x);
  for (int turn = 0; turn < most; ++turn) {
    new_rows_.clear();
    for (std::size_t i = 0; i < rows_.rows().size(); ++i)
      if (!isIdle(i) && !hasDirection(i)) new_rows_.push_back(i);
    if (new_rows_.empty()) return;
    copy(x, here_), copy(directions_at_, x);
    findConditions();
    for (const std::size_t row : new_rows_) takeDirection(row);
    copy(here_, x);
    findConditions();
  }
  for (std::size_t i = 0; i < rows_.rows().size(); ++i)
    if (!isIdle(i) && !hasDirection(i)) takeDirection(i);
}

void Multipliers::updateDirections() {
  findConditions();
  takeDirections(), takeBends();
}

/// Directions that turn far in a step, as of bodies that tumble, are taken anew before rounds along them come to rest; a few times,
/// because where that goes to and fro only rounds to the end are left.
bool Multipliers::mayLeaveDirections() {
  constexpr int most = 4;
  return carries_ && keepsDirections() && times_left_++ < most;
}

/// Rows that hold or push. Of constraints whose conditions may change the speeds are to end. Others keep the mean of the step, which is
/// not zero of what is driven; pushes keep all.
std::vector<Multipliers::Held> Multipliers::findHeld(ConstRows moves) const {
  std::vector<Held> held;
  const auto& constraints = system_->actors().lagrangian_constraints;
  std::size_t row = 0;
  for (std::size_t i = 0; i < constraints.size(); ++i) {
    const bool changes = dynamic_cast<const ChangesConditions*>(constraints[i]) && !dynamic_cast<const GuessesForces*>(constraints[i]);
    for (; row < ends_[i]; ++row) {
      const LagrangianRows::Row& each = rows_.rows()[row];
      const double l = solve_.l[Eigen::Index(row)];
      const bool pushes = each.kind == LagrangianRows::Kind::push && l > 0 && !(each.factor > 0 && l >= each.factor);
      if (!pushes && each.kind != LagrangianRows::Kind::equal) continue;
      const double speed = along(row, moves), to_and_fro = pushes ? 0 : 0.5 * (speed - start_speeds_[row]);
      held.push_back({row, pushes && !changes, changes ? speed : to_and_fro});
    }
  }
  return held;
}

double Multipliers::along(std::size_t row, ConstRows moves) const {
  double sum = 0;
  for (const auto& [at, gradient] : rows_.entriesOf(rows_.rows()[row])) sum += gradient.dot(moves[at]);
  return sum;
}

/// A^-1 J^T of them, J of where the step starts and ends. False: a solve gave nothing.
bool Multipliers::respondToTurn(const std::vector<Held>& held, LinearSolver& solver, SystemMatrix& matrix, StopToken stop,
                                StepReport& report) {
  constexpr double sharpest = -0.5;  // the cosine of 120 degrees
  requested_.clear(), solutions_.clear();
  for (const Held& each : held) {
    Vector& direction = directions_[each.row];
    const Vector& before = start_directions_[each.row];
    if (direction.count() != system_->independentRows()) direction.resize(system_->independentRows());
    pullBack(each.row, direction);
    if (dot(direction, before) > sharpest * norm(direction) * norm(before)) axpy(1, before, direction), scale(0.5, direction);
    request(direction, responses_[each.row]);
  }
  return solveRequested(solver, matrix, stop, report);
}

bool Multipliers::turnVelocities(LinearSolver& solver, SystemMatrix& matrix, StopToken stop, StepReport& report) {
  if (empty() || !has_changed_ || rule_.old_share == 0 || !rule_.has_velocities) return false;
  findConditions();
  assert(solve_.g.size() == solve_.l.size() && rows_.rows().size() == start_speeds_.size() && "rows are as many all through a step");
  const Rows v = system_->independent(system_->v);
  const std::vector<Held> held = findHeld(system_->mappingChain().direction(v));
  directions_.resize(std::max(directions_.size(), rows_.rows().size()));
  responses_.resize(std::max(responses_.size(), rows_.rows().size()));
  if (held.empty() || !respondToTurn(held, solver, matrix, stop, report)) return false;
  const auto count = Eigen::Index(held.size());
  Eigen::MatrixXd w(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const ConstRows response = system_->mappingChain().direction(responses_[held[std::size_t(i)].row]);
    for (Eigen::Index j = 0; j < count; ++j) w(j, i) = rule_.weight * along(held[std::size_t(j)].row, response);
  }
  const Eigen::VectorXd forces = findTurn(w, held, stop, report);
  report.stopped = report.stopped || stop.isStopAsked();
  if (report.stopped) return false;
  for (Eigen::Index i = 0; i < count; ++i) axpy(rule_.weight * forces[i], responses_[held[std::size_t(i)].row], v);
  return true;
}

/// By what the forces of a step change to take the speeds. A push ends where it would have to pull, and lets go.
Eigen::VectorXd Multipliers::findTurn(const Eigen::MatrixXd& w, const std::vector<Held>& held, StopToken stop, StepReport& report) const {
  constexpr double little = 1e-6;  // of the largest speed
  ConditionForces turn;
  std::vector<LagrangianRows::Row> rows;
  Eigen::VectorXd speeds(w.rows()), before = Eigen::VectorXd::Zero(w.rows());
  for (const Held& each : held) {
    const auto at = Eigen::Index(rows.size());
    LagrangianRows::Row row = rows_.rows()[each.row];
    row.kind = each.pushes ? LagrangianRows::Kind::push : LagrangianRows::Kind::equal;
    if (each.pushes) before[at] = solve_.l[Eigen::Index(each.row)];
    speeds[at] = each.speed;
    rows.push_back(row), turn.sizes.push_back(solve_.sizes[each.row]);
  }
  turn.w = w, turn.l = before, turn.g = speeds - w * before;
  turn.solve(rows, stop);
  const Eigen::VectorXd change = turn.l - before, left = speeds + w * change;
  double worst = change.allFinite() ? 0 : std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < held.size(); ++i)
    if (const double off = left[Eigen::Index(i)], size = turn.sizes[i]; size > 0)
      worst = std::max(worst, (held[i].pushes ? std::max(-off, 0.0) : std::abs(off)) / size);
  if (worst > little * largest(system_->independent(system_->v)) && report.constraints_converged) {
    report.constraints_converged = false;
    report.constraint_reason = fmt::format("{} finds no speeds after a corner that all Lagrangian constraints allow: one is off by {:.3g} "
                                           "m/s. A smaller dt helps", system_->integrator().path(), worst);
  }
  return std::isfinite(worst) ? change : Eigen::VectorXd::Zero(w.rows());
}

}  // namespace stroma
