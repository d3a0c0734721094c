// SPDX-License-Identifier: LGPL-2.1-or-later
// The loop of preconditioned conjugate gradients. Inline for the reason given in vector.h.
#pragma once
#include <cmath>

#include "components/iterative_solvers/conjugate_gradients.h"
#include "framework/algebra/linear_solver.h"

namespace stroma::cg {

/// Work space, each of shape (rows).
struct Directions {
  Vector r, p, q, z;
  /// Allocates only when the number of rows changed.
  void resize(Index rows) {
    if (r.count() == rows) return;
    for (Vector* vector : {&r, &p, &q, &z}) vector->resize(rows);
  }
};

/// Where a solve ends.
struct Limits {
  static constexpr double of_other_units = 1e-22;  ///< the smallest cosine where rows are turns, or of other masses
  int iterations = 25;
  double residual = 0;  ///< stop when |b - A x| is at most this
  StopToken stop{};
  bool by_inverse = false;  ///< |r|^2 is r.z with z = B r, in which forces and torques are alike
  double smallest_cosine = 1e-10;  ///< between p and A p, below which the matrix is taken for a singular one
};

/// Iterates from r = b - A x until the |r| of the recurrence is small enough (converged) or something else ends it.
/// report.relative_residual is |r|. `has_step`: work.z is B r.
template <class Product, class Precondition, class Record>
SolveStop descend(Product&& product, Precondition&& precondition, Record&& record, const Limits& limits, bool has_step,
                  Directions& work, Rows x, SolveReport& report) {
  constexpr double noise = 1e-14;
  const double smallest_cosine = limits.by_inverse ? Limits::of_other_units : limits.smallest_cosine;
  auto& [r, p, q, z] = work;
  if (!has_step) precondition(r.rows(), z.rows());
  double rho = inner(r, z);
  copyShared(z, p);
  for (;;) {
    product(p.rows(), q.rows());
    ++report.iterations;
    const Curvature curve = curvature(p, q);
    const double size = std::sqrt(curve.pp) * std::sqrt(curve.qq);
    if (!std::isfinite(curve.pq) || !std::isfinite(rho)) return SolveStop::not_finite;
    if (curve.pq <= smallest_cosine * size || rho <= 0)
      return curve.pq < -noise * size ? SolveStop::not_definite : SolveStop::breakdown;
    const double alpha = rho / curve.pq;
    report.relative_residual = std::sqrt(reduceResidual(alpha, q, r));
    const double before = rho;
    if (limits.by_inverse) {
      precondition(r.rows(), z.rows());
      rho = inner(r, z);
      if (report.relative_residual > 0) report.relative_residual = std::sqrt(std::abs(rho));
    }
    record(report.relative_residual);
    if (!std::isfinite(report.relative_residual)) return SolveStop::not_finite;
    const bool converged = report.relative_residual <= limits.residual;
    if (!converged && limits.stop.isStopAsked()) return SolveStop::stopped;
    if (converged || report.iterations == limits.iterations) {
      axpy(alpha, p, x);
      return converged ? SolveStop::converged : SolveStop::iteration_limit;
    }
    if (!limits.by_inverse) {
      precondition(r.rows(), z.rows());
      rho = inner(r, z);
    }
    advance(alpha, rho / before, z, p, x);
  }
}

/// Solves A x = b from the x given.
///   product(p, out): out = A p;  precondition(r, z): z = B r, B symmetric and positive definite;
///   record(|r|): called after each iteration.
/// The |r| of the recurrence leaves b - A x behind by round-off, so where an iteration ends the residual itself is
/// computed, and the method starts anew from there when it is not small enough, as long as that helps.
/// `report.relative_residual` is |b - A x|, see Limits (the caller divides by |b|). A matrix that shows itself to be singular or
/// not definite leaves the last iterate in x. `has_residual`: work.r is b - A x; `has_step`: work.z is B (b - A x), or B b where x is
/// zero and there is no residual.
template <class Product, class Precondition, class Record>
SolveReport preconditioned(Product&& product, Precondition&& precondition, Record&& record, const Limits& limits,
                           ConstRows b, Directions& work, Rows x, bool has_residual = false, bool has_step = false) {
  SolveReport report;
  if (!has_residual) {
    copyShared(b, work.r);
    if (inner(x, x) != 0) {
      product(x, work.q.rows());
      axpy(-1, work.q, work.r);
      has_step = false;
    }
  }
  const auto measure = [&](double square) {
    if (!limits.by_inverse || square == 0 || !std::isfinite(square)) return std::sqrt(square);
    if (!has_step) precondition(work.r.rows(), work.z.rows());
    has_step = true;
    return std::sqrt(std::abs(inner(work.r, work.z)));
  };
  double entered = measure(inner(work.r, work.r));
  report.relative_residual = entered;
  if (!std::isfinite(entered)) report.stop = SolveStop::not_finite;
  if (!(entered > limits.residual)) return report;
  for (;;) {
    report.stop = descend(product, precondition, record, limits, has_step, work, x, report);
    has_step = false;
    if (report.stop != SolveStop::converged) return report;
    product(x, work.q.rows());
    copyShared(b, work.r);
    report.relative_residual = measure(reduceResidual(1, work.q, work.r));
    if (report.relative_residual <= 1.1 * limits.residual) return report;
    report.stop = report.iterations == limits.iterations ? SolveStop::iteration_limit : SolveStop::stagnated;
    // a restart that gains less than half fights round-off
    if (report.stop == SolveStop::iteration_limit || report.relative_residual > 0.5 * entered) return report;
    entered = report.relative_residual;
  }
}

}  // namespace stroma::cg
