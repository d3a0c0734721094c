// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/condensation/condition_forces.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stroma {

using Kind = LagrangianRows::Kind;

void ConditionForces::solve(const std::vector<Row>& rows) {
  constexpr int most_rounds = 100, newton_steps = 12, sweeps = 20;
  // where a round no longer helps, round-off of forces that are large for their conditions is left
  constexpr double settled = 1e-13, near = 1e-9;
  scaleRows(rows);
  findGroups(rows);
  const double largest = sizeOfConditions();
  const auto measure = [&] { return unsettled_ = largest > 0 ? residual() / largest : residual(); };
  const auto restart = [&](const Eigen::VectorXd& q) {
    if (&q != &q_) q_ = q;
    r_ = offset_;
    r_.noalias() += scaled_ * q_;
    return measure();
  };
  double before = restart(q_);
  for (int round = 0; round < most_rounds && unsettled_ > settled; ++round) {
    double least = unsettled_;
    best_ = q_;
    for (int k = 0; k < newton_steps && unsettled_ > settled && newtonStep(); ++k)
      if (measure() < least) least = unsettled_, best_ = q_;
    if (!(restart(best_) > settled) || (round > 0 && least < near && least > 0.5 * before)) break;
    before = least;
    for (int k = 0; k < sweeps * (round + 1); ++k) sweep();
    if (!std::isfinite(measure())) break;
  }
  l = scale_.cwiseProduct(q_);
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (rows[i].kind == Kind::given) l[Eigen::Index(i)] = rows[i].factor;
}

/// Zero for rows that nothing moves; what rubs goes with what pushes. What is given goes to the offset.
void ConditionForces::scaleRows(const std::vector<Row>& rows) {
  const Eigen::Index count = g.size();
  double most = 0;
  for (Eigen::Index i = 0; i < count; ++i)
    if (const double size = sizes[std::size_t(i)]; size > 0) most = std::max(most, std::abs(w(i, i)) / (size * size));
  scale_.resize(count), q_.setZero(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Row& row = rows[std::size_t(i)];
    const double own = w(i, i), size = sizes[std::size_t(i)];
    if (row.kind == Kind::rub && i > 0)
      scale_[i] = scale_[i - 1];
    else
      scale_[i] = own > 1e-14 * most * size * size ? 1 / std::sqrt(own) : 0;
    if (row.kind == Kind::given) g += row.factor * w.col(i);
  }
  for (Eigen::Index i = 0; i < count; ++i)
    if (rows[std::size_t(i)].kind != Kind::given && scale_[i] > 0) q_[i] = l[i] / scale_[i];
  scaled_ = scale_.asDiagonal() * w * scale_.asDiagonal();
  offset_ = scale_.cwiseProduct(g);
}

void ConditionForces::findGroups(const std::vector<Row>& rows) {
  groups_.clear();
  for (int i = 0; i < int(rows.size());) {
    const Row& row = rows[std::size_t(i)];
    Group group{row.kind, i, i + 1, 0, std::numeric_limits<double>::infinity()};
    if (row.kind == Kind::push) {
      if (row.factor > 0 && scale_[i] > 0) group.most = row.factor / scale_[i];
      while (group.end < int(rows.size()) && rows[std::size_t(group.end)].kind == Kind::rub)
        group.mu = rows[std::size_t(group.end++)].factor;
    }
    i = group.end;
    if (group.kind != Kind::given && moves(group.first)) groups_.push_back(group);
    if (group.kind == Kind::given) q_[group.first] = 0;
  }
}

/// The largest of those that forces have to mend; gaps far from contact have no say.
double ConditionForces::sizeOfConditions() const {
  double size = 0;
  for (const Group& group : groups_) {
    const double value = offset_[group.first];
    if (group.kind == Kind::equal || value < 0) size = std::max(size, std::abs(value));
  }
  return size;
}

double ConditionForces::rateOf(const Group& group) const {
  const int first = group.first + 1, count = group.end - first;
  return scaled_.block(first, first, count, count).cwiseAbs().rowwise().sum().maxCoeff();
}

void ConditionForces::cutToBound(Eigen::Ref<Eigen::VectorXd> tangents, double bound) const {
  if (const double length = tangents.norm(); length > bound) tangents *= bound / length;
}

/// The largest of the functions' values.
double ConditionForces::residual() {
  double worst = 0;
  const auto note = [&worst](double value) {
    if (!(value <= worst) && !std::isnan(worst)) worst = value;  // a NaN stays
  };
  for (const Group& group : groups_) {
    const int i = group.first;
    if (group.kind == Kind::equal) {
      note(std::abs(r_[i]));
      continue;
    }
    note(std::abs(q_[i] - std::clamp(q_[i] - r_[i], 0.0, group.most)));
    const int count = group.end - i - 1;
    if (count == 0) continue;
    if (const double rate = rateOf(group); rate > 0) {
      wanted_ = q_.segment(i + 1, count) - r_.segment(i + 1, count) / rate;
      cutToBound(wanted_, group.mu * q_[i]);
      note(rate * (wanted_ - q_.segment(i + 1, count)).cwiseAbs().maxCoeff());
    }
  }
  return worst;
}

void ConditionForces::change(int row, double to) {
  if (to == q_[row]) return;
  r_ += (to - q_[row]) * scaled_.col(row);
  q_[row] = to;
}

void ConditionForces::sweep() {
  for (const Group& group : groups_) {
    const int i = group.first;
    const double wanted = q_[i] - r_[i] / scaled_(i, i);
    change(i, group.kind == Kind::equal ? wanted : std::clamp(wanted, 0.0, group.most));
    const int count = group.end - i - 1;
    if (count == 0) continue;
    const double rate = rateOf(group);
    if (!(rate > 0)) continue;
    wanted_ = q_.segment(i + 1, count) - r_.segment(i + 1, count) / rate;
    cutToBound(wanted_, group.mu * q_[i]);
    for (int k = 0; k < count; ++k) change(i + 1 + k, wanted_[k]);
  }
}

void ConditionForces::addActive(int row, double value) {
  active_.push_back(row);
  value_[row] = value;
}

/// The function of a group and its derivative, at q_ and r_.
void ConditionForces::linearise(const Group& group) {
  const int i = group.first, first = i + 1, count = group.end - first;
  if (group.kind == Kind::push) {
    const double wanted = q_[i] - r_[i];
    if (!(wanted > 0 && wanted < group.most)) return;  // at a bound, where newtonStep() has put it
  }
  addActive(i, r_[i]);
  derivative_.row(i) = scaled_.row(i);
  if (count == 0) return;
  const double rate = rateOf(group);
  if (!(rate > 0) || group.mu == 0) return;
  wanted_ = q_.segment(first, count) - r_.segment(first, count) / rate;
  const double length = wanted_.norm(), bound = group.mu * std::max(q_[i], 0.0);
  if (length <= bound) {
    for (int k = first; k < group.end; ++k) addActive(k, r_[k]), derivative_.row(k) = scaled_.row(k);
    return;
  }
  wanted_ /= length;
  const double turn = bound / length;
  for (int k = 0; k < count; ++k) {
    const int row = first + k;
    addActive(row, q_[row] - bound * wanted_[k]);
    derivative_.row(row).setZero();
    for (int j = 0; j < count; ++j) {
      const double across = turn * ((j == k ? 1 : 0) - wanted_[k] * wanted_[j]);
      derivative_.row(row) += across / rate * scaled_.row(first + j);
      derivative_(row, first + j) -= across;
    }
    derivative_(row, row) += 1;
    derivative_(row, i) -= group.mu * wanted_[k];
  }
}

/// False where there is no step.
bool ConditionForces::newtonStep() {
  const int count = int(q_.size());
  active_.clear();
  derivative_.resize(count, count), value_.resize(count);
  for (const Group& group : groups_) {
    if (group.kind != Kind::push) continue;
    const int i = group.first;
    const double wanted = q_[i] - r_[i];
    if (wanted > 0 && wanted < group.most) continue;
    change(i, wanted > 0 ? group.most : 0);
    for (int k = i + 1; k < group.end; ++k)
      if (!(wanted > 0)) change(k, 0);
  }
  for (const Group& group : groups_) linearise(group);
  if (active_.empty()) return false;
  jacobian_ = derivative_(active_, active_);
  step_ = -value_(active_);
  factors_.compute(jacobian_);
  if (factors_.rcond() > 1e-14) {
    step_ = factors_.solve(step_).eval();
  } else {  // rows that say the same twice: the shortest solution
    Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> general;
    general.setThreshold(1e-12);
    general.compute(jacobian_);
    step_ = general.solve(step_).eval();
  }
  if (!step_.allFinite()) return false;
  for (std::size_t k = 0; k < active_.size(); ++k) q_[active_[k]] += step_[Eigen::Index(k)];
  r_ = offset_;
  r_.noalias() += scaled_ * q_;
  return true;
}

}  // namespace stroma
