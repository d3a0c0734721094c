// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/direct_solvers/symmetric_part_factor.h"

#include <cmath>
#include <utility>

namespace stroma {
namespace {

constexpr std::size_t most_products = 60;
constexpr double wanted = 1e-12, good_enough = 1e-8;

}  // namespace

bool SymmetricPartFactor::analyse(const BlockMatrix& matrix, StopToken stop) {
  matrix_ = part_ = matrix;
  transposed_.resize(std::size_t(matrix.blocks()));
  for (Index row = 0; row < matrix.rows(); ++row)
    for (Index s = matrix.rowStart()[row]; s < matrix.rowStart()[row + 1]; ++s)
      transposed_[s] = matrix.slot(matrix.columns()[s], row);
  if (!symmetric_) symmetric_ = CholeskyFactor::make();
  lu_.reset();
  basis_.clear();
  work_.resize(matrix.rows());
  return symmetric_->analyse(part_, stop);
}

void SymmetricPartFactor::load(const BlockMatrix& matrix) {
  matrix_.values() = matrix.values();
  const std::vector<double>& a = matrix_.values();
  std::vector<double>& s = part_.values();
  for (std::size_t block = 0; block < transposed_.size(); ++block)
    for (std::size_t r = 0; r < 3; ++r)
      for (std::size_t c = 0; c < 3; ++c)
        s[9 * block + 3 * r + c] =
            0.5 * (a[9 * block + 3 * r + c] + a[9 * std::size_t(transposed_[block]) + 3 * c + r]);
  lu_.reset();
  symmetric_->load(part_);
}

SolveStop SymmetricPartFactor::factor(Index& row, StopToken stop) {
  stop_ = stop, is_given_up_ = false;
  const SolveStop end = symmetric_->factor(row, stop);
  return end == SolveStop::converged || end == SolveStop::stopped ? end : factorUnsymmetric(row, stop);
}

SolveStop SymmetricPartFactor::factorUnsymmetric(Index& row, StopToken stop) {
  row = -1;
  lu_ = std::make_unique<InterruptibleFactor<LUFactor>>(LUFactor::make);
  SolveStop end = SolveStop::stopped;
  if (lu_->analyse(matrix_, stop)) {
    lu_->load(matrix_);
    end = lu_->factor(row, stop);
  }
  if (end != SolveStop::converged) lu_.reset();
  return end;
}

void SymmetricPartFactor::apply(ConstRows b, Rows x) {
  const StopToken stop = std::exchange(stop_, {});  // later, its owner may have gone
  if (!lu_ && !is_given_up_ && solveByProducts(b, x, stop)) return;
  Index row = -1;
  is_given_up_ = is_given_up_ || stop.isStopAsked();
  if (lu_ || (!is_given_up_ && factorUnsymmetric(row, stop) == SolveStop::converged))
    lu_->apply(b, x);
  else
    is_given_up_ = true, clear(x);
}

/// GMRES on A S^-1 y = b, x = S^-1 y, without a restart. False when it stops short of what counts as solved.
bool SymmetricPartFactor::solveByProducts(ConstRows b, Rows x, StopToken stop) {
  const double size = norm(b);
  if (size == 0) {
    clear(x);
    return true;
  }
  const auto vector = [this](std::size_t i) -> Vector& {
    while (basis_.size() <= i) basis_.emplace_back().resize(matrix_.rows());
    return basis_[i];
  };
  copy(b, vector(0));
  scale(1 / size, vector(0));
  // R of the Hessenberg matrix's QR by columns, its rotations, and the rotated right-hand side
  std::vector<std::vector<double>> r;
  std::vector<double> cosine, sine, g{size};
  while (r.size() < most_products) {
    if (stop.isStopAsked()) return false;
    const std::size_t j = r.size();
    symmetric_->apply(basis_[j], work_);
    Vector& next = vector(j + 1);
    matrix_.multiply(work_, next);
    std::vector<double> column;
    for (std::size_t i = 0; i <= j; ++i) {
      column.push_back(dot(next, basis_[i]));
      axpy(-column[i], basis_[i], next);
    }
    const double length = norm(next);
    if (!std::isfinite(length)) return false;
    if (length > 0) scale(1 / length, next);
    for (std::size_t i = 0; i < j; ++i) {
      const double above = column[i];
      column[i] = cosine[i] * above + sine[i] * column[i + 1];
      column[i + 1] = cosine[i] * column[i + 1] - sine[i] * above;
    }
    const double both = std::hypot(column[j], length);
    if (both == 0) return false;
    cosine.push_back(column[j] / both), sine.push_back(length / both);
    column[j] = both;
    g.push_back(-sine[j] * g[j]);
    g[j] *= cosine[j];
    r.push_back(std::move(column));
    if (std::abs(g[j + 1]) <= wanted * size) break;
  }
  if (!(std::abs(g[r.size()]) <= good_enough * size)) return false;
  for (std::size_t i = r.size(); i-- > 0;) {
    for (std::size_t k = i + 1; k < r.size(); ++k) g[i] -= r[k][i] * g[k];
    g[i] /= r[i][i];
  }
  clear(work_);
  for (std::size_t i = 0; i < r.size(); ++i) axpy(g[i], basis_[i], work_);
  symmetric_->apply(work_, x);
  return true;
}

Factorisation::Cost SymmetricPartFactor::cost() const {
  if (lu_) return lu_->cost();
  constexpr double products = 10;
  const Cost once = symmetric_->cost();
  return {once.factor, products * (once.apply + 20e-9 * double(matrix_.blocks()))};
}

}  // namespace stroma
