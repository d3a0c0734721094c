// SPDX-License-Identifier: LGPL-2.1-or-later
// GMRES (Saad, Schultz 1986) preconditioned from the right, for matrices that are not symmetric: A B y = b, x = B y, with the y
// of the Krylov space for which |b - A B y| is least. It starts anew after `restart` products, which bounds its memory. Inline
// for the reason given in vector.h.
#pragma once
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "components/iterative_solvers/preconditioned_conjugate_gradients.h"

namespace stroma::gmres {

constexpr std::size_t restart = 30;

/// Work space; it grows with the products that a solve needs.
struct Space {
  std::vector<Vector> basis;  ///< orthonormal, each of shape (rows)
  Vector sum, z;
  Index rows = 0;
  void resize(Index count) {
    if (rows == count) return;
    rows = count;
    basis.clear();
    for (Vector* each : {&sum, &z}) each->resize(count);
  }
  Vector& vector(std::size_t i) {
    while (basis.size() <= i) basis.emplace_back().resize(rows);
    return basis[i];
  }
};

/// The least-squares problem of a space: R of the Hessenberg matrix by columns, its rotations, and the turned right side.
class Triangle {
 public:
  explicit Triangle(double beta) : g_{beta} {}
  /// `column` of the Hessenberg matrix, whose last entry is `below`. False when nothing is left to divide by.
  bool add(std::vector<double> column, double below) {
    const std::size_t j = columns_.size();
    for (std::size_t i = 0; i < j; ++i) {
      const double above = column[i];
      column[i] = cosine_[i] * above + sine_[i] * column[i + 1];
      column[i + 1] = cosine_[i] * column[i + 1] - sine_[i] * above;
    }
    const double both = std::hypot(column[j], below);
    if (!(both > 0)) return false;
    cosine_.push_back(column[j] / both), sine_.push_back(below / both);
    column[j] = both;
    g_.push_back(-sine_[j] * g_[j]);
    g_[j] *= cosine_[j];
    columns_.push_back(std::move(column));
    return true;
  }
  std::size_t size() const { return columns_.size(); }
  double residual() const { return std::abs(g_.back()); }
  /// Coordinates of y in the basis.
  std::vector<double> solution() const {
    std::vector<double> y(g_.begin(), g_.begin() + std::ptrdiff_t(size()));
    for (std::size_t i = size(); i-- > 0;) {
      for (std::size_t k = i + 1; k < size(); ++k) y[i] -= columns_[k][i] * y[k];
      y[i] /= columns_[i][i];
    }
    return y;
  }

 private:
  std::vector<std::vector<double>> columns_;
  std::vector<double> cosine_, sine_, g_;
};

/// Products from the residual in the basis' first vector, of length `beta`, until x is good enough by the recurrence, the space is
/// full or the limit is reached: converged. Else the reason why it cannot go on.
template <class Product, class Precondition, class Record>
SolveStop descend(Product&& product, Precondition&& precondition, Record&& record, const cg::Limits& limits, double beta,
                  Space& space, Rows x, SolveReport& report) {
  scale(1 / beta, space.vector(0));
  Triangle triangle(beta);
  SolveStop stop = SolveStop::converged;
  while (triangle.size() < restart && report.iterations < limits.iterations && triangle.residual() > limits.residual) {
    if (limits.stop.isStopAsked()) return SolveStop::stopped;
    const std::size_t j = triangle.size();
    Vector& next = space.vector(j + 1);
    precondition(space.basis[j].rows(), space.z.rows());
    product(space.z.rows(), next.rows());
    ++report.iterations;
    std::vector<double> column;
    for (std::size_t i = 0; i <= j; ++i) {
      column.push_back(dot(next, space.basis[i]));
      axpy(-column[i], space.basis[i], next);
    }
    const double length = norm(next);
    if (!std::isfinite(length)) return SolveStop::not_finite;
    if (!triangle.add(std::move(column), length)) {
      stop = SolveStop::breakdown;
      break;
    }
    record(triangle.residual());
    if (length > 0) scale(1 / length, next);
  }
  const std::vector<double> y = triangle.solution();
  clear(space.sum);
  for (std::size_t i = 0; i < y.size(); ++i) axpy(y[i], space.basis[i], space.sum);
  precondition(space.sum.rows(), space.z.rows());
  axpy(1, space.z, x);
  return stop;
}

/// Solves A x = b from the x given; see cg::preconditioned() for the arguments. `report.relative_residual` is |b - A x|.
template <class Product, class Precondition, class Record>
SolveReport solve(Product&& product, Precondition&& precondition, Record&& record, const cg::Limits& limits, ConstRows b,
                  Space& space, Rows x) {
  constexpr double least_gain = 0.9;  // of a whole space: more is left, and it gets no further
  SolveReport report;
  for (double before = std::numeric_limits<double>::infinity();;) {
    Vector& r = space.vector(0);
    copy(b, r);
    if (dot(x, x) != 0) {
      product(x, space.z.rows());
      axpy(-1, space.z, r);
    }
    const double now = report.relative_residual = norm(r);
    if (!std::isfinite(now)) {
      report.stop = SolveStop::not_finite;
      return report;
    }
    if (now <= 1.1 * limits.residual) {
      report.stop = SolveStop::converged;
      return report;
    }
    if (report.stop == SolveStop::breakdown) return report;
    if (report.iterations >= limits.iterations || now > least_gain * before) {
      report.stop = report.iterations >= limits.iterations ? SolveStop::iteration_limit : SolveStop::stagnated;
      return report;
    }
    before = now;
    report.stop = descend(product, precondition, record, limits, now, space, x, report);
    if (report.stop == SolveStop::stopped || report.stop == SolveStop::not_finite) return report;
  }
}

}  // namespace stroma::gmres
