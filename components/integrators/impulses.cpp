// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/integrators/impulses.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stroma {

using Kind = LagrangianRows::Kind;

void Impulses::solve(const std::vector<Row>& rows, double weight) {
  equal_.clear(), other_.clear();
  for (int i = 0; i < int(rows.size()); ++i) {
    const Row& row = rows[std::size_t(i)];
    if (row.kind == Kind::given) {
      p[i] = weight * row.factor;
      g += p[i] * w.col(i);
    } else {
      (row.kind == Kind::equal ? equal_ : other_).push_back(i);
    }
  }
  scaleRows(rows);
  reduced_ = scaled_(other_, other_);
  reduced_g_ = scaled_g_(other_);
  if (!equal_.empty()) eliminate();
  sweep(rows, weight);
  for (std::size_t k = 0; k < other_.size(); ++k) p[other_[k]] = scale_[other_[k]] * total_[Eigen::Index(k)];
  if (equal_.empty()) return;
  if (!other_.empty()) offset_ += eliminated_ * total_;
  for (std::size_t k = 0; k < equal_.size(); ++k) p[equal_[k]] = -scale_[equal_[k]] * offset_[Eigen::Index(k)];
}

/// Zero for rows that nothing moves; what rubs goes with what pushes.
void Impulses::scaleRows(const std::vector<Row>& rows) {
  scale_.resize(g.size());
  double most = 0;
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (sizes[i] > 0) most = std::max(most, std::abs(w(Eigen::Index(i), Eigen::Index(i))) / (sizes[i] * sizes[i]));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto k = Eigen::Index(i);
    const double own = std::abs(w(k, k));
    if (rows[i].kind == Kind::rub && i > 0)
      scale_[k] = scale_[k - 1];
    else
      scale_[k] = own > 1e-14 * most * sizes[i] * sizes[i] ? 1 / std::sqrt(own) : 0;
  }
  scaled_ = scale_.asDiagonal() * w * scale_.asDiagonal();
  scaled_g_ = scale_.cwiseProduct(g);
}

/// Takes what is equal out of reduced_ and reduced_g_: its impulses are -(offset_ + eliminated_ * those of the rest).
void Impulses::eliminate() {
  inner_ = scaled_(equal_, equal_);
  coupling_ = scaled_(equal_, other_);
  values_ = scaled_g_(equal_);
  factors_.compute(inner_);
  // rows that say the same twice leave a matrix without an inverse: the shortest solution then
  if (factors_.rcond() > 1e-13) {
    offset_ = factors_.solve(values_);
    if (!other_.empty()) eliminated_ = factors_.solve(coupling_);
  } else {
    Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> general;
    general.setThreshold(1e-12);
    general.compute(inner_);
    offset_ = general.solve(values_);
    if (!other_.empty()) eliminated_ = general.solve(coupling_);
  }
  if (other_.empty()) return;
  coupling_ = scaled_(other_, equal_);
  reduced_.noalias() -= coupling_ * eliminated_;
  reduced_g_.noalias() -= coupling_ * offset_;
}

/// One of other_ changes its impulse: by how much its condition changes.
double Impulses::change(int row, double by) {
  total_[row] += by;
  residual_ += by * reduced_.col(row);
  return std::abs(by) * reduced_(row, row);
}

/// Projected Gauss and Seidel for other_. The step along the tangents is one over the largest eigenvalue of their block,
/// so that where nothing changes any more Coulomb's law holds.
void Impulses::sweep(const std::vector<Row>& rows, double weight) {
  const auto count = Eigen::Index(other_.size());
  total_.resize(count), most_.resize(count), residual_.resize(count);
  if (count == 0) return;
  for (Eigen::Index k = 0; k < count; ++k) {
    const int i = other_[std::size_t(k)];
    const Row& row = rows[std::size_t(i)];
    const bool moves = scale_[i] > 0, is_bounded = moves && row.kind == Kind::push && row.factor > 0;
    total_[k] = moves ? p[i] / scale_[i] : 0;
    most_[k] = is_bounded ? weight * row.factor / scale_[i] : std::numeric_limits<double>::infinity();
  }
  residual_ = reduced_g_;
  residual_.noalias() += reduced_ * total_;
  const double least = 1e-14 * reduced_.diagonal().cwiseAbs().maxCoeff(), largest = reduced_g_.cwiseAbs().maxCoeff();
  for (; sweeps_left_ > 0; --sweeps_left_) {
    const double moved = sweepOnce(rows, least);
    unsettled_ = largest > 0 ? moved / largest : moved;
    if (moved <= 1e-13 * largest) return;
    // numbers that are not finite have no place to go to; the largest of a NaN and another number may be the other one
    if (!std::isfinite(moved) || !residual_.allFinite()) {
      unsettled_ = std::numeric_limits<double>::infinity();
      return;
    }
  }
}

double Impulses::sweepOnce(const std::vector<Row>& rows, double least) {
  const auto rowOf = [&](int k) -> const Row& { return rows[std::size_t(other_[std::size_t(k)])]; };
  const int count = int(other_.size());
  double moved = 0;
  for (int i = 0; i < count;) {
    const int push = i++;
    if (reduced_(push, push) > least) {
      const double wanted = total_[push] - residual_[push] / reduced_(push, push);
      moved = std::max(moved, change(push, std::clamp(wanted, 0.0, most_[push]) - total_[push]));
    }
    const int first = i;
    while (i < count && rowOf(i).kind == Kind::rub) ++i;
    if (i > first) moved = std::max(moved, rub(first, i, rowOf(first).factor * total_[push], least));
  }
  return moved;
}

double Impulses::rub(int first, int end, double bound, double least) {
  const int tangents = end - first;
  const double rate = reduced_.block(first, first, tangents, tangents).cwiseAbs().rowwise().sum().maxCoeff();
  if (!(rate > least)) return 0;
  wanted_ = total_.segment(first, tangents) - residual_.segment(first, tangents) / rate;
  if (const double length = wanted_.norm(); length > bound) wanted_ *= bound / length;
  double moved = 0;
  for (int k = 0; k < tangents; ++k) moved = std::max(moved, change(first + k, wanted_[k] - total_[first + k]));
  return moved;
}

}  // namespace stroma
