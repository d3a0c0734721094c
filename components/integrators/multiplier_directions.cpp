// SPDX-License-Identifier: LGPL-2.1-or-later
// Of the forces of constraint: the directions J^T along which they act (multipliers.h).
#include <Eigen/Dense>
#include <algorithm>

#include "components/integrators/multipliers.h"
#include "framework/mechanics/condition_roles.h"

namespace stroma {

/// 1 or -1 when the gradient is that of the row before, or its opposite; else 0.
double Multipliers::likeRowBefore(std::size_t row) const {
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
  is_aimed_[row] = true;
  Vector& direction = directions_[row];
  if (direction.count() != system_->independentRows()) direction.resize(system_->independentRows());
  like_[row] = row > 0 && is_aimed_[row - 1] ? likeRowBefore(row) : 0;
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

/// Rows with the gradients that they had a round before keep what answers to them.
void Multipliers::forgetChanged() {
  const auto &rows = rows_.rows(), &old = old_rows_.rows();
  is_answered_.resize(rows.size(), false);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto now = rows_.entriesOf(rows[i]);
    if (rows.size() != old.size() || !std::ranges::equal(now, old_rows_.entriesOf(old[i]))) is_answered_[i] = false;
  }
}

/// J^T of rows that may have a force, where they were found: they are few of those that may come near in a step.
void Multipliers::takeDirections() {
  const std::size_t count = rows_.rows().size();
  directions_.resize(std::max(directions_.size(), count));
  like_.assign(count, 0), is_aimed_.assign(count, false);
  if (carries_) is_answered_.clear();
  for (std::size_t i = 0; i < count; ++i)
    if (i < is_answered_.size() && is_answered_[i])
      is_aimed_[i] = true;
    else if (!isIdle(i))
      takeDirection(i);
  if (carries_) copy(system_->independent(system_->x), aimed_at_);
}

/// What has come near since directions were taken gets its own from there.
void Multipliers::aimAtNew() {
  constexpr int most = 8;  // of times that going back there brings others near
  const Rows x = system_->independent(system_->x);
  for (int turn = 0; turn < most; ++turn) {
    new_rows_.clear();
    for (std::size_t i = 0; i < rows_.rows().size(); ++i)
      if (!isIdle(i) && !isAimed(i)) new_rows_.push_back(i);
    if (new_rows_.empty()) return;
    copy(x, here_), copy(aimed_at_, x);
    findConditions();
    for (const std::size_t row : new_rows_) takeDirection(row);
    copy(here_, x);
    findConditions();
  }
  for (std::size_t i = 0; i < rows_.rows().size(); ++i)
    if (!isIdle(i) && !isAimed(i)) takeDirection(i);
}

void Multipliers::aim() {
  findConditions();
  takeDirections(), takeBends();
}

/// Directions that turn far in a step, as of bodies that tumble, are taken anew before rounds along them come to rest; a few times,
/// because where that goes to and fro only rounds to the end are left.
bool Multipliers::leavesDirections() {
  constexpr int most = 4;
  return keepsDirections() && times_left_++ < most;
}

/// Rows of constraints whose conditions may change, that hold or push.
std::vector<std::size_t> Multipliers::heldByChanging() const {
  std::vector<std::size_t> held;
  const auto& constraints = system_->actors().lagrangian_constraints;
  std::size_t row = 0;
  for (std::size_t i = 0; i < constraints.size(); ++i) {
    const bool changes = dynamic_cast<const ChangesConditions*>(constraints[i]) != nullptr;
    for (; row < ends_[i]; ++row) {
      const auto kind = rows_.rows()[row].kind;
      const bool pushes = kind == LagrangianRows::Kind::push && solve_.l[Eigen::Index(row)] > 0;
      if (changes && (kind == LagrangianRows::Kind::equal || pushes)) held.push_back(row);
    }
  }
  return held;
}

bool Multipliers::turnVelocities(LinearSolver& solver, SystemMatrix& matrix, StopToken stop, StepReport& report) {
  if (empty() || !has_changed_ || rule_.old_share == 0 || !rule_.has_velocities) return false;
  constexpr double sharpest = -0.5;  // the cosine of 120 degrees
  findConditions();
  const std::vector<std::size_t> held = heldByChanging();
  const auto count = Eigen::Index(held.size());
  const Rows v = system_->independent(system_->v);
  Eigen::MatrixXd w(count, count);
  Eigen::VectorXd speeds(count);
  const auto along = [&](std::size_t row, ConstRows direction) {
    double sum = 0;
    for (const auto& [at, gradient] : rows_.entriesOf(rows_.rows()[row])) sum += gradient.dot(direction[at]);
    return sum;
  };
  for (Eigen::Index i = 0; i < count; ++i) {
    const std::size_t row = held[std::size_t(i)];
    const Vector& before = start_directions_[row];
    pullBack(row, right_side_);
    if (dot(right_side_, before) > sharpest * norm(right_side_) * norm(before)) axpy(1, before, right_side_);
    if (!answer(solver, matrix, responses_[row], stop, report)) return false;
    const ConstRows response = system_->mappingChain().direction(responses_[row]);
    for (Eigen::Index j = 0; j < count; ++j) w(j, i) = along(held[std::size_t(j)], response);
  }
  const ConstRows moves = system_->mappingChain().direction(v);
  for (Eigen::Index i = 0; i < count; ++i) speeds[i] = along(held[std::size_t(i)], moves);
  const Eigen::VectorXd impulses = w.completeOrthogonalDecomposition().solve(speeds);
  for (Eigen::Index i = 0; i < count; ++i) axpy(-impulses[i], responses_[held[std::size_t(i)]], v);
  return count > 0;
}

}  // namespace stroma
