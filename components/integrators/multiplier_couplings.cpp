// SPDX-License-Identifier: LGPL-2.1-or-later
// Of the forces of constraint: what they move, A^-1 J^T, and W (multipliers.h). Along directions W is summed for rows that share what
// moves: of free rigid bodies those of one body, so that a heap costs as its contacts and not as their square.
#include <utility>

#include "components/integrators/multipliers.h"
#include "components/integrators/whole_matrix.h"

namespace stroma {

/// A^-1 J^T, of what is not known
bool Multipliers::respond(LinearSolver& solver, SystemMatrix& matrix, StopToken stop, StepReport& report) {
  if (carries_) computeNewDirections();
  const std::size_t count = rows_.rows().size();
  responses_.resize(std::max(responses_.size(), count));
  is_answered_.resize(count, false);
  new_answers_.clear(), requested_.clear(), solutions_.clear();
  const auto isAlike = [&](std::size_t i) { return like_[i] != 0 && is_answered_[i - 1]; };
  for (std::size_t i = 0; i < count; ++i) {
    if (isIdle(i) || is_answered_[i]) continue;
    if (!isAlike(i)) request(directions_[i], responses_[i]);
    is_answered_[i] = true, new_answers_.push_back(i);
  }
  if (new_answers_.empty()) return true;
  has_new_answers_ = true;
  if (!solveRequested(solver, matrix, stop, report)) return false;
  for (const std::size_t i : new_answers_) {
    Vector& response = responses_[i];
    if (!isAlike(i)) {
      bends_.takeFrom(response);
      continue;
    }
    if (response.count() != system_->independentRows()) response.resize(system_->independentRows());
    copy(responses_[i - 1], response);
    scale(like_[i], response);
  }
  return true;
}

/// Rows of W.
void Multipliers::findLive() {
  std::swap(live_, coupled_);
  live_.clear();
  for (std::size_t i = 0; i < rows_.rows().size(); ++i)
    if (!isIdle(i)) live_.push_back(i);
}

/// What bodies answer to loads; the step goes on without them where they are coupled. False: a solve gave nothing.
bool Multipliers::solveForBodies(LinearSolver& solver, SystemMatrix& matrix, StopToken stop, StepReport& report) {
  requested_.clear(), solutions_.clear();
  for (std::size_t k = 0; k < BodyRows::loads; ++k) {
    if (body_loads_[k].count() != system_->independentRows()) body_loads_[k].resize(system_->independentRows());
    bodies_.load(int(k), body_loads_[k]);
    request(body_loads_[k], body_answers_[k]);
  }
  if (!solveRequested(solver, matrix, stop, report)) return false;
  knows_bodies_ = bodies_.takeAnswers(body_loads_, body_answers_);
  return true;
}

/// Where all rows that may have a force are of free bodies that share them; bodies are asked for their motion only then. False: a solve
/// gave nothing.
bool Multipliers::takeBodyRows(bool is_first, LinearSolver& solver, SystemMatrix& matrix, StopToken stop, StepReport& report) {
  const bool was_of_bodies = std::exchange(is_of_bodies_, false);
  if (is_first) knows_bodies_ = asked_bodies_ = false;
  const bool may_be = !carries_ && !isOnce() && rule_.old_share == 0 && uncoupled_.empty() && !yields_.empty();
  if (may_be && !dynamic_cast<WholeMatrix*>(&matrix) && bodies_.findBodies(matrix)) {
    findLive();
    is_of_bodies_ = !live_.empty() && bodies_.take(rows_, live_);
    if (is_of_bodies_ && !std::exchange(asked_bodies_, true) && !solveForBodies(solver, matrix, stop, report)) return false;
    is_of_bodies_ = is_of_bodies_ && knows_bodies_;
    if (is_of_bodies_)
      bodies_.respond();
    else
      std::swap(live_, coupled_);  // couple() compares with the rows of the previous W
  }
  if (!is_of_bodies_) {
    if (was_of_bodies) is_answered_.clear(), has_new_answers_ = true;
    return true;
  }
  const double factor = rule_.weight * rule_.displacement;
  own_.assign(rows_.rows().size(), 0);
  for (std::size_t k = 0; k < live_.size(); ++k) own_[live_[k]] = BodyRows::couple(bodies_.rows()[k], bodies_.rows()[k], factor);
  is_without_w_ = redundant_.wouldSweep(rows_.rows(), live_, bodies_.touched(), solve_.searches > searches_before_);
  if (!is_without_w_) bodies_.couple(factor, solve_.w);
  return true;
}

/// W. Along directions that stay it is what it was while the same rows are alive.
void Multipliers::couple() {
  const auto& rows = rows_.rows();
  findLive();
  if (!std::exchange(has_new_answers_, false) && keepsDirections() && live_ == coupled_ && own_.size() == rows.size()) return;
  const auto count = Eigen::Index(live_.size());
  const double factor = rule_.weight * rule_.displacement;
  solve_.w.resize(count, count);
  own_.assign(rows.size(), 0);
  if (couplesByDirections()) overlaps_.find(directions_, live_, system_->independentRows()), solve_.w.setZero();
  for (Eigen::Index i = 0; i < count; ++i) {
    const Vector& response = responses_[live_[std::size_t(i)]];
    if (couplesByDirections()) {
      for (const std::size_t j : overlaps_.of(response)) solve_.w(Eigen::Index(j), i) = factor * overlaps_.along(j, response);
    } else {
      const ConstRows along = system_->mappingChain().direction(response);
      for (Eigen::Index j = 0; j < count; ++j) {
        double sum = 0;
        for (const auto& [at, gradient] : rows_.entriesOf(rows[live_[std::size_t(j)]])) sum += gradient.dot(along[at]);
        solve_.w(j, i) = factor * sum;
      }
    }
    own_[live_[std::size_t(i)]] = solve_.w(i, i);
  }
}

void DirectionOverlaps::find(const std::vector<Vector>& directions, const std::vector<std::size_t>& live, Index rows) {
  directions_ = &directions, live_ = &live;
  reached_.clear(), first_.assign(1, 0);
  reaches_.resize(std::size_t(rows));
  for (auto& each : reaches_) each.clear();
  marks_.assign(live.size(), 0), mark_ = 0;
  for (std::size_t number = 0; number < live.size(); ++number) {
    const ConstRows direction = directions[live[number]];
    for (Index at = 0; at < direction.count; ++at)
      if (!direction[at].isZero(0)) reached_.push_back(at), reaches_[std::size_t(at)].push_back(number);
    first_.push_back(reached_.size());
  }
}

const std::vector<std::size_t>& DirectionOverlaps::of(ConstRows response) {
  found_.clear();
  ++mark_;
  for (Index at = 0; at < response.count; ++at) {
    if (reaches_[std::size_t(at)].empty() || response[at].isZero(0)) continue;
    for (const std::size_t number : reaches_[std::size_t(at)])
      if (std::exchange(marks_[number], mark_) != mark_) found_.push_back(number);
  }
  return found_;
}

double DirectionOverlaps::along(std::size_t number, ConstRows response) const {
  const ConstRows direction = (*directions_)[(*live_)[number]];
  double sum = 0;
  for (std::size_t k = first_[number]; k < first_[number + 1]; ++k) sum += direction[reached_[k]].dot(response[reached_[k]]);
  return sum;
}

}  // namespace stroma
