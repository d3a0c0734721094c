// SPDX-License-Identifier: LGPL-2.1-or-later
// Of the forces of constraint: what they move, A^-1 J^T, and W (multipliers.h). Along directions W is summed for rows that share what
// moves: of free rigid bodies those of one body, so that a heap costs as its contacts and not as their square.
#include <utility>

#include "components/integrators/multipliers.h"

namespace stroma {

/// A^-1 J^T, of what is not known
bool Multipliers::respond(LinearSolver& solver, SystemMatrix& matrix, StopToken stop, StepReport& report) {
  if (carries_) aimAtNew();
  const std::size_t count = rows_.rows().size();
  responses_.resize(std::max(responses_.size(), count));
  is_answered_.resize(count, false);
  new_answers_.clear(), asked_.clear(), answers_.clear();
  const auto isAlike = [&](std::size_t i) { return like_[i] != 0 && is_answered_[i - 1]; };
  for (std::size_t i = 0; i < count; ++i) {
    if (isIdle(i) || is_answered_[i]) continue;
    if (!isAlike(i)) ask(directions_[i], responses_[i]);
    is_answered_[i] = true, new_answers_.push_back(i);
  }
  if (new_answers_.empty()) return true;
  has_new_answers_ = true;
  if (!answerAsked(solver, matrix, stop, report)) return false;
  for (const std::size_t i : new_answers_) {
    Vector& response = responses_[i];
    if (!isAlike(i)) {
      takeBendsFrom(response);
      continue;
    }
    if (response.count() != system_->independentRows()) response.resize(system_->independentRows());
    copy(responses_[i - 1], response);
    scale(like_[i], response);
  }
  return true;
}

/// W. Along directions that stay it is what it was while the same rows are alive.
void Multipliers::couple() {
  const auto& rows = rows_.rows();
  std::swap(live_, coupled_);
  live_.clear();
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (!isIdle(i)) live_.push_back(i);
  if (!std::exchange(has_new_answers_, false) && keepsDirections() && live_ == coupled_ && own_.size() == rows.size()) return;
  const auto count = Eigen::Index(live_.size());
  const double factor = rule_.weight * rule_.displacement;
  solve_.w.resize(count, count);
  own_.assign(rows.size(), 0);
  if (couplesByDirections()) findReached(), solve_.w.setZero();
  for (Eigen::Index i = 0; i < count; ++i) {
    const Vector& response = responses_[live_[std::size_t(i)]];
    if (couplesByDirections()) {
      findMoved(response);
      for (const std::size_t j : moved_) solve_.w(Eigen::Index(j), i) = factor * alongReached(j, response);
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

/// Where the directions of rows of W are not zero: of two rigid bodies, of however many there are.
void Multipliers::findReached() {
  reached_.clear(), first_reached_.assign(1, 0);
  reaches_.resize(std::size_t(system_->independentRows()));
  for (auto& each : reaches_) each.clear();
  marks_.assign(live_.size(), 0), mark_ = 0;
  for (std::size_t number = 0; number < live_.size(); ++number) {
    const ConstRows direction = directions_[live_[number]];
    for (Index at = 0; at < direction.count; ++at)
      if (!direction[at].isZero(0)) reached_.push_back(at), reaches_[std::size_t(at)].push_back(number);
    first_reached_.push_back(reached_.size());
  }
}

/// The rows of W whose directions are not zero where a response is not: those of the bodies that it moves.
void Multipliers::findMoved(ConstRows response) {
  moved_.clear();
  ++mark_;
  for (Index at = 0; at < response.count; ++at) {
    if (reaches_[std::size_t(at)].empty() || response[at].isZero(0)) continue;
    for (const std::size_t number : reaches_[std::size_t(at)])
      if (std::exchange(marks_[number], mark_) != mark_) moved_.push_back(number);
  }
}

/// The direction of a row of W with a response.
double Multipliers::alongReached(std::size_t number, ConstRows response) const {
  const ConstRows direction = directions_[live_[number]];
  double sum = 0;
  for (std::size_t k = first_reached_[number]; k < first_reached_[number + 1]; ++k)
    sum += direction[reached_[k]].dot(response[reached_[k]]);
  return sum;
}

}  // namespace stroma
