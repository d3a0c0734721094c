// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/mechanics/condition_forces.h"

#include <cmath>
#include <utility>

namespace stroma {

namespace {
// where a step no longer helps, round-off of forces that are large for their conditions is left
constexpr double settled = 1e-13, rounded = 1e-11, near = 1e-9, coarse = 1e-6;
constexpr double none = std::numeric_limits<double>::infinity();

}  // namespace

void ConditionForces::solve(const std::vector<Row>& rows, StopToken stop, const std::vector<double>& allowed) {
  stop_ = stop, allowed_ = allowed, ++searches;
  live_.clear();
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (rows[i].kind != Kind::given || rows[i].factor != 0) live_.push_back(i);
  scaleRows(rows);
  findGroups(rows);
  size_ = 0;  // of those that forces have to mend; gaps far from contact have no say
  for (const Group& group : groups_) size_ = std::max(size_, group.pushes ? -offset_[group.first] : std::abs(offset_[group.first]));
  unsettled_ = none, least_ = q_;
  restart(q_), note();
  if (unsettled_ > 1.5 * enough) newton(), note();
  if (unsettled_ > rounded && unsettled_ < coarse && !isLittle()) settle();
  const bool are_many = live_.size() > 100;
  const auto search = [&](auto way) {
    const double before = std::exchange(unsettled_, none);
    const Eigen::VectorXd q = least_;
    way(), newton(), note();
    if (!are_many || !isLittle()) settle();
    if (!(unsettled_ < before)) unsettled_ = before, least_ = q;
  };
  // The order is one of time alone: rounds of the interior-point method cost the cube of the rows, sweeps their square. Of few rows
  // it goes first, as it keeps what is symmetric so.
  if (are_many && unsettled_ > near && !isLittle()) search([this] { sweep(); });
  if (unsettled_ > near && !isLittle()) search([this] { searchInside(); });
  if (!are_many && unsettled_ > coarse && !isLittle()) search([this] { sweep(); });
  if (unsettled_ > coarse && !isLittle()) search([this] { searchWithSlides(); });
  if (unsettled_ > near && unsettled_ < coarse && !isOver() && !isLittle()) contradiction = 2 * unsettled_ * size_;
  l.setZero();
  for (std::size_t k = 0; k < live_.size(); ++k)
    l[Eigen::Index(live_[k])] = std::isfinite(unsettled_) ? scale_[Eigen::Index(k)] * least_[Eigen::Index(k)] : unsettled_;
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (rows[i].kind == Kind::given) l[Eigen::Index(i)] = rows[i].factor;
}

/// Zero for rows that nothing moves; what rubs goes with what pushes. What is given goes to the offset.
void ConditionForces::scaleRows(const std::vector<Row>& rows) {
  const auto count = Eigen::Index(live_.size());
  double most = 0;
  for (Eigen::Index k = 0; k < count; ++k)
    if (const double size = sizes[live_[std::size_t(k)]]; size > 0) most = std::max(most, std::abs(w(k, k)) / (size * size));
  scale_.resize(count), across_.resize(count), step_.resize(count), q_.setZero(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const std::size_t row = live_[std::size_t(k)];
    const double own = std::abs(w(k, k)), size = sizes[row];
    scale_[k] = rows[row].kind == Kind::rub && k > 0 ? scale_[k - 1] : own > 1e-14 * most * size * size ? 1 / std::sqrt(own) : 0;
    if (rows[row].kind == Kind::given)
      for (Eigen::Index j = 0; j < count; ++j) g[Eigen::Index(live_[std::size_t(j)])] += rows[row].factor * w(j, k);
    else if (scale_[k] > 0)
      q_[k] = l[Eigen::Index(row)] / scale_[k];
  }
  scaled_ = scale_.asDiagonal() * w * scale_.asDiagonal();
  offset_ = Eigen::VectorXd::NullaryExpr(count, [&](Eigen::Index k) { return scale_[k] * g[Eigen::Index(live_[std::size_t(k)])]; });
}

void ConditionForces::findGroups(const std::vector<Row>& rows) {
  groups_.clear();
  const int count = int(live_.size());
  const auto at = [&](int k) -> const Row& { return rows[live_[std::size_t(k)]]; };
  for (int i = 0, end = 1; i < count; i = end++) {
    const Row& row = at(i);
    Group group{.pushes = row.kind == Kind::push, .first = i, .end = i + 1};
    while (group.pushes && end < count && at(end).kind == Kind::rub) ++end;
    if (const int tangents = end - i - 1; tangents > 0 && at(i + 1).factor > 0) {
      group.mu = at(i + 1).factor;
      group.rate = scaled_.block(i + 1, i + 1, tangents, tangents).cwiseAbs().rowwise().sum().maxCoeff();
      if (group.rate > 0) group.end = end;
    }
    // where W has a negative diagonal, as that of a body that buckles, what is equal has a force and what pushes none
    const bool moves = group.pushes ? scaled_(i, i) > 0 : row.kind == Kind::equal && scale_[i] > 0;
    if (moves && group.pushes && row.factor > 0) group.most = row.factor / scale_[i];
    if (moves) groups_.push_back(group);
    const int first = moves ? group.end : i;
    q_.segment(first, end - first).setZero();
  }
}

void ConditionForces::restart(const Eigen::VectorXd& q) {
  if (&q != &q_) q_ = q;
  r_ = offset_;
  r_.noalias() += scaled_ * q_;
}

void ConditionForces::change(int row, double to) {
  if (to == q_[row]) return;
  r_ += (to - q_[row]) * scaled_.col(row);
  q_[row] = to;
}

void ConditionForces::findWanted(const Group& group) {
  const int first = group.first + 1, count = group.tangents();
  wanted_ = q_.segment(first, count) - r_.segment(first, count) / group.rate;
  friction_ = cutFriction(wanted_, group.mu, q_[group.first]);
}

/// The function of what is equal or pushes.
double ConditionForces::offAt(const Group& group) const {
  return group.pushes ? offOfPush(q_[group.first], r_[group.first], group.most) : std::abs(r_[group.first]);
}

/// The largest function of what rubs.
double ConditionForces::offAlong(const Group& group) {
  if (group.tangents() == 0) return 0;
  findWanted(group);
  return group.rate * (wanted_ - q_.segment(group.first + 1, group.tangents())).cwiseAbs().maxCoeff();
}

double ConditionForces::residual() {
  double worst = 0;
  for (const Group& group : groups_)
    for (const double off : {offAt(group), offAlong(group)})
      if (!(off <= worst) && !std::isnan(worst)) worst = off;  // a NaN stays
  return size_ > 0 ? worst / size_ : worst;
}

void ConditionForces::note() {
  if (const double now = residual(); now < unsettled_) unsettled_ = now, least_ = q_;
}

/// Nothing better is found by a search.
bool ConditionForces::isLittle(double part) {
  if (unsettled_ * size_ < contradiction) return true;
  if (allowed_.empty() || !std::isfinite(unsettled_)) return false;
  if (q_ != least_) restart(least_);
  const auto holds = [&](const Group& group, std::size_t row, double off) {
    return off <= part * allowed_[row] * sizes[row] * scale_[group.first];
  };
  return std::all_of(groups_.begin(), groups_.end(), [&](const Group& group) {
    const auto row = live_.begin() + group.first;
    return holds(group, *row, offAt(group)) && (group.tangents() == 0 || holds(group, row[1], offAlong(group)));
  });
}

void ConditionForces::Packed::set(const Eigen::MatrixXd& w) {
  begins.assign(1, 0), rows.clear(), numbers.clear();
  for (Eigen::Index k = 0; k < w.cols(); ++k) {
    for (Eigen::Index i = 0; i < w.rows(); ++i) {
      if (w(i, k) == 0) continue;
      rows.push_back(int(i));
      numbers.push_back(w(i, k));
    }
    begins.push_back(int(rows.size()));
  }
}

/// From the best place, notes where it comes to.
void ConditionForces::sweep() {
  // Sweeps that come nearer take some hundred; where what is left has not become half of it in `look` of them they creep, and
  // what follows is faster.
  constexpr int most = 2000, look = 50;
  packed_.set(scaled_);
  const auto go = [&](int row, double by) {
    const auto end = std::size_t(packed_.begins[std::size_t(row) + 1]);
    for (auto k = std::size_t(packed_.begins[std::size_t(row)]); k < end && by != 0; ++k) r_[packed_.rows[k]] += by * packed_.numbers[k];
    q_[row] += by;
  };
  restart(least_);
  double before = none;
  for (int k = 1; k <= most && unsettled_ > near && !isOver(); ++k) {
    for (const Group& group : groups_) {
      const double q = q_[group.first], to = q - r_[group.first] / scaled_(group.first, group.first);
      go(group.first, (group.pushes ? std::clamp(to, 0.0, group.most) : to) - q);
      if (group.tangents() > 0) findWanted(group);
      for (int row = group.first + 1; row < group.end; ++row) go(row, wanted_[row - group.first - 1] - q_[row]);
    }
    spent += double(packed_.numbers.size());
    note();
    if (k % 5 == 0 && q_ == least_ && isLittle()) break;
    if (k % look == 0 && !(unsettled_ < 0.5 * std::exchange(before, unsettled_))) break;
  }
}

/// Newton steps from q_ while they help, and back to the best of them.
void ConditionForces::newton() {
  constexpr int most = 12;
  double now = residual(), least = now;
  best_ = q_;
  for (int k = 0; k < most && now > settled && !isOver(); ++k) {
    const bool goes_on = newtonStep();  // if not, forces have gone to their bounds all the same
    const double last = std::exchange(now, residual());
    if (now < least) least = now, best_ = q_;
    if (!goes_on || !(now > rounded || now < 0.5 * last)) break;
  }
  restart(best_);
}

/// Forces of rows that say nearly the same are drawn to where they were, by r + shift (q - where) instead of r, and that again
/// and again: proximal points (Rockafellar 1976).
void ConditionForces::settle() {
  constexpr int most = 30, look = 5;
  constexpr double first = 1e-3, last = 1e-7;
  const Eigen::VectorXd offset = offset_, diagonal = scaled_.diagonal();
  Eigen::VectorXd where = least_;
  for (double shift = first; shift >= 0.9 * last && unsettled_ > rounded && !isOver(); shift *= 0.1) {
    double before = unsettled_;
    scaled_.diagonal().array() += shift, where = least_;
    for (int turn = 1; turn <= most && unsettled_ > settled && !isOver(); ++turn) {
      offset_ = offset - shift * where;
      restart(where), newton();
      r_ -= shift * (q_ - where), where = q_, note();
      if (turn % look == 0 && !(unsettled_ < 0.5 * std::exchange(before, unsettled_))) break;
    }
    offset_ = offset, scaled_.diagonal() = diagonal, restart(least_), newton(), note();
  }
}

/// Takes to their bounds the forces that belong there, and collects the other rows.
void ConditionForces::findActive() {
  active_.clear();
  for (Group& group : groups_) {
    const double wanted = q_[group.first] - r_[group.first];
    group.is_active = !group.pushes || (wanted > 0 && wanted < group.most);
    group.at = wanted > 0 ? group.most : 0;
  }
  for (const Group& group : groups_)
    for (int row = group.first; row < group.end && !group.is_active; ++row)
      if (row == group.first || group.at == 0) change(row, group.at);
  for (Group& group : groups_) {
    if (!group.is_active) continue;
    for (int row = group.first; row < group.end; ++row) active_.push_back(row);
    if (group.tangents() == 0) continue;
    findWanted(group);
    group.slips = friction_.slips();
    if (!group.slips) continue;
    group.turn = friction_.bound / friction_.wanted;
    const int first = group.first + 1, count = group.tangents();
    across_.segment(first, count) = (q_.segment(first, count) - r_.segment(first, count) / group.rate) / friction_.wanted;
  }
}

/// The derivative of the functions of active_; step_ has their negative values.
ConditionForces::Square ConditionForces::linearise() {
  const auto count = Eigen::Index(active_.size());
  derivative_.resize(std::size_t(count * count));
  Square a(derivative_.data(), count, count);
  Eigen::Index k = 0;
  for (const Group& group : groups_) {
    if (!group.is_active) continue;
    const Eigen::Index push = k;
    for (int row = group.first; row < group.end; ++row, ++k) {
      if (row == group.first || !group.slips) {
        for (Eigen::Index at = 0; at < count; ++at) a(k, at) = scaled_(row, active_[std::size_t(at)]);
        step_[k] = -r_[row];
        continue;
      }
      a.row(k).setZero();
      for (int other = group.first + 1; other < group.end; ++other) {
        const double turned = group.turn * ((other == row ? 1 : 0) - across_[row] * across_[other]);
        for (Eigen::Index at = 0; at < count; ++at) a(k, at) += turned / group.rate * scaled_(other, active_[std::size_t(at)]);
        a(k, push + other - group.first) -= turned;
      }
      a(k, k) += 1;
      a(k, push) -= group.mu * across_[row];
      step_[k] = group.mu * std::max(q_[group.first], 0.0) * across_[row] - q_[row];
    }
  }
  return a;
}

/// step_ = a^-1 step_ by elimination with pivots, in place, a few columns at a time. False: rows depend on each other.
bool ConditionForces::eliminate(Square a) {
  constexpr Eigen::Index width = 16;
  const Eigen::Index count = a.rows();
  double most = 0;
  for (Eigen::Index first = 0; first < count; first += width) {
    const Eigen::Index last = std::min(first + width, count), rest = count - last;
    for (Eigen::Index k = first; k < last; ++k) {
      Eigen::Index best = 0;
      const double pivot = a.col(k).tail(count - k).cwiseAbs().maxCoeff(&best);
      most = std::max(most, pivot);
      if (!(pivot > 1e-14 * most)) return false;
      if (best > 0) a.row(k).swap(a.row(k + best)), std::swap(step_[k], step_[k + best]);
      for (Eigen::Index i = k + 1; i < count; ++i) {
        a(i, k) /= a(k, k);
        a.row(i).segment(k + 1, last - k - 1) -= a(i, k) * a.row(k).segment(k + 1, last - k - 1);
        step_[i] -= a(i, k) * step_[k];
      }
    }
    for (Eigen::Index k = first; k < last; ++k)
      for (Eigen::Index i = k + 1; i < last; ++i) a.row(i).tail(rest) -= a(i, k) * a.row(k).tail(rest);
    a.bottomRightCorner(rest, rest).noalias() -= a.block(last, first, rest, last - first) * a.block(first, last, last - first, rest);
  }
  for (Eigen::Index k = count - 1; k >= 0; --k) {
    const Eigen::Index rest = count - k - 1;
    step_[k] = (step_[k] - a.row(k).tail(rest).dot(step_.segment(k + 1, rest))) / a(k, k);
  }
  return true;
}

/// False where there is no step.
bool ConditionForces::newtonStep() {
  findActive();
  const auto count = Eigen::Index(active_.size());
  if (count == 0) return false;
  ++steps, spent += std::pow(double(count), 3);
  if (!eliminate(linearise())) {  // rows that say the same twice: the shortest solution
    Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> general;
    general.setThreshold(1e-12), general.compute(linearise());
    step_.head(count) = general.solve(step_.head(count)).eval();
  }
  if (!step_.head(count).allFinite()) return false;
  for (Eigen::Index k = 0; k < count; ++k) q_[active_[std::size_t(k)]] += step_[k];
  restart(q_);
  return true;
}

ConditionForces::Violation ConditionForces::worst(const std::vector<Row>& rows, const std::vector<double>& allowed) {
  Violation found;
  const auto note = [&](std::size_t row, double off, bool rubs) {
    if (sizes[row] > 0) off /= sizes[row];
    if (!allowed.empty() && off <= allowed[row]) return;
    if (!(off <= found.off) && !std::isnan(found.off)) found = {row, off, rubs};
  };
  auto group_of = groups_.begin();
  std::size_t next = 0;  // of live_
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double value = rows[i].value;
    const bool is_live = next < live_.size() && live_[next] == i;
    if (is_live) r_[Eigen::Index(next)] = scale_[Eigen::Index(next)] * value;
    const bool is_found = is_live && group_of != groups_.end() && group_of->first == int(next);
    next += is_live;
    if (is_found)
      ++group_of;
    else if (rows[i].kind == Kind::equal || (rows[i].kind == Kind::push && !(value >= 0)))
      note(i, std::abs(value), false);  // nothing moves it
  }
  if (next != live_.size()) return found;
  q_ = least_;
  for (const Group& group : groups_) {
    const std::size_t row = live_[std::size_t(group.first)];
    note(row, offAt(group) / scale_[group.first], false);
    if (group.tangents() > 0) note(row + 1, offAlong(group) / scale_[group.first], true);
  }
  return found;
}

}  // namespace stroma
