// SPDX-License-Identifier: LGPL-2.1-or-later
// MinResLinearSolver: minimal residuals for A x = b with A symmetric, definite or not (Paige and Saunders 1975).
//
// Lanczos' recurrence builds orthonormal v_1, v_2, ... with A V_k = V_{k+1} T_k, T_k tridiagonal:
//   beta_{k+1} v_{k+1} = A v_k - alpha_k v_k - beta_k v_{k-1},   alpha_k = v_k.A v_k
// and x_k minimises |b - A x| over their span: T_k = Q R by one rotation (c, s) per iteration, with R of three
// diagonals (gamma_k, delta_k, epsilon_k), so directions and x follow from the last two of each:
//   w_k = (v_k - delta_k w_{k-1} - epsilon_k w_{k-2}) / gamma_k,   x += tau_k w_k,   |r_k| = |s_k| |r_{k-1}|
//
// An iteration costs one product and about half as many vector operations again as conjugate gradients. Use it where
// the matrix is indefinite (a tangent past buckling, an inverted element): conjugate gradients break down there and
// say so, this method solves. On a definite matrix |r| falls in every iteration, and both need about the same number.
//
// It stops when |r| <= tolerance |b| and max |D^-1 r| <= max(tolerance, 1e-3) max |x| with D the diagonal blocks (bodies far lighter
// than others would stay where they are; a block that is not positive definite counts as its largest |entry|); after `iterations` products;
// when b = 0; when a number is not finite; when the matrix is singular and b has a part outside its range:
// |A r| <= 1e-9 |A| |r| while |r| is not small, or rising again from below 1e-8, the report says breakdown and x is the
// least-squares solution; and as stagnated when b - A x,
// computed once at the end, is larger than what the recurrence says and than the tolerance. Where some rows are turns, of rigid
// frames, it solves S A S y = S b, x = S y, with S of row_scales.h: |r| and |b| are then |S r| and |S b|, on which the unit of
// length has no influence.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <MinResLinearSolver iterations="100" tolerance="1e-9"/>
//   <MechanicalObject position="0 0 0  1 0 0  0 1 0  0 0 1"/>
//   <UniformMass totalMass="1"/>
//   <FixedProjectiveConstraint indices="0 1 2"/>
// </Node>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "components/iterative_solvers/krylov_solver.h"
#include "components/iterative_solvers/light_rows.h"
#include "components/iterative_solvers/row_scales.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class MinResLinearSolver final : public KrylovSolver {
 public:
  SolveReport solve(SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms) override;

 private:
  /// Work space of a matrix.
  struct Lanczos {
    Vector v, v_before, product;  ///< v_k, v_{k-1}; A v_k, later beta_{k+1} v_{k+1}
    Vector w, w_before, w_next;   ///< w_{k-1}, w_{k-2}, w_k
    RowScales scales;
    Vector unscaled, right_side;  ///< S p and S b, where there are scales
    LightRows light;
    void resize(Index rows) {
      if (v.count() == rows) return;
      for (Vector* vector : {&v, &v_before, &product, &w, &w_before, &w_next}) vector->resize(rows);
    }
  };
  SolveStop iterate(const SystemMatrix& matrix, Lanczos& work, Rows x, double residual, const cg::Limits& limits, SolveReport& report);
  SolveReport solveFrom(const SystemMatrix& matrix, Lanczos& work, ConstRows b, Rows x, const cg::Limits& limits);
  SolveReport solveScaled(const SystemMatrix& matrix, Lanczos& work, ConstRows b, Rows x, int most);
  void scaledProduct(const SystemMatrix& matrix, Lanczos& work, ConstRows p, Rows out) const;
  double scaledResidual(const SystemMatrix& matrix, Lanczos& work, ConstRows b, ConstRows x) const;

  PerMatrix<Lanczos> work_;
};

/// w_next = (v - delta w - epsilon w_before) / gamma;  x += tau w_next. 4 reads, 2 writes.
void advance(ConstRows v, double delta, ConstRows w, double epsilon, ConstRows w_before, double gamma, double tau,
             Rows w_next, Rows x) {
  const double inverse = 1 / gamma;
  const double* __restrict pv = v.data, * __restrict pw = w.data, * __restrict pb = w_before.data;
  double* __restrict out = w_next.data, * __restrict px = x.data;
#pragma omp simd
  for (std::size_t i = 0; i < v.doubles(); ++i) {
    const double value = (pv[i] - delta * pw[i] - epsilon * pb[i]) * inverse;
    out[i] = value;
    px[i] += tau * value;
  }
}

/// From v = r, unscaled, |r| = residual.
SolveStop MinResLinearSolver::iterate(const SystemMatrix& matrix, Lanczos& work, Rows x, double residual, const cg::Limits& limits,
                                      SolveReport& report) {
  Vector &v = work.v, &v_before = work.v_before, &av = work.product;
  Vector &w = work.w, &w_before = work.w_before, &w_next = work.w_next;
  clear(v_before), clear(w), clear(w_before);
  scale(1 / residual, v);
  double beta = 0, cosine = -1, sine = 0, delta_bar = 0, epsilon = 0, phi = residual, size = 0;
  double lowest = std::numeric_limits<double>::infinity();  // of |A r| / (|A| |r|)
  for (;;) {
    scaledProduct(matrix, work, v, av);
    ++report.iterations;
    axpy(-beta, v_before, av);
    const double alpha = dot(v, av);
    axpy(-alpha, v, av);
    const double beta_next = norm(av);
    if (!std::isfinite(beta_next) || !std::isfinite(alpha)) return SolveStop::not_finite;
    size = std::max(size, std::hypot(alpha, std::max(beta, beta_next)));  // grows towards the norm of A

    // the rotation before acts on this column of T, then the one that makes beta_{k+1} vanish
    const double delta = cosine * delta_bar + sine * alpha, gamma_bar = sine * delta_bar - cosine * alpha;
    const double epsilon_next = sine * beta_next;
    delta_bar = -cosine * beta_next;
    const double gamma = std::hypot(gamma_bar, beta_next);
    // |A r| = phi |(gamma_bar, delta_bar)|: zero means that no direction lowers |r|. Lanczos' vectors lose their
    // orthogonality, so it falls to some 1e-9 of |A| and rises again after that, with x running away. No number: A = 0.
    const double slope = std::hypot(gamma_bar, delta_bar) / size;
    lowest = std::min(lowest, slope);
    if (!(slope > 1e-9) || (lowest <= 1e-8 && slope > 10 * lowest)) return SolveStop::breakdown;
    cosine = gamma_bar / gamma, sine = beta_next / gamma;
    advance(v, delta, w, epsilon, w_before, gamma, cosine * phi, w_next, x);
    phi *= sine;
    report.relative_residual = phi / norm_b_;
    record(report.relative_residual);
    if (phi <= limits.residual) return SolveStop::converged;
    if (isStopAsked()) return SolveStop::stopped;
    if (report.iterations == limits.iterations) return SolveStop::iteration_limit;

    std::swap(w_before, w), std::swap(w, w_next);
    std::swap(v_before, v), std::swap(v, av);
    scale(1 / beta_next, v);
    beta = beta_next, epsilon = epsilon_next;
  }
}

/// out = S A S p, or A p without scales.
void MinResLinearSolver::scaledProduct(const SystemMatrix& matrix, Lanczos& work, ConstRows p, Rows out) const {
  if (work.scales.empty()) return product(matrix, p, out);
  copy(p, work.unscaled);
  work.scales.multiply(work.unscaled);
  product(matrix, work.unscaled, out);
  work.scales.multiply(out);
}

/// work.v = b - S A S x; returns its size.
double MinResLinearSolver::scaledResidual(const SystemMatrix& matrix, Lanczos& work, ConstRows b, ConstRows x) const {
  copy(b, work.v);
  if (dot(x, x) != 0) {
    scaledProduct(matrix, work, x, work.product);
    axpy(-1, work.product, work.v);
  }
  return norm(work.v);
}

SolveReport MinResLinearSolver::solve(SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms) {
  SolveReport report;
  if (!begin(matrix, b, x, terms, report)) return report;
  Lanczos& work = work_.of(matrix);
  work.resize(b.count);
  work.scales.take(matrix);
  if (!work.scales.empty()) return solveScaled(matrix, work, b, x, iterations_);
  report = solveFrom(matrix, work, b, x, {iterations_, target(), terms_.stop});
  if (report.stop != SolveStop::converged || !work.light.areLeft(matrix, relativeTarget(terms), work.v, x)) return report;
  report.stop = SolveStop::iteration_limit;
  const int before = report.iterations;
  if (before == iterations_) return report;
  work.scales.take(matrix, true);
  report = solveScaled(matrix, work, b, x, iterations_ - before);
  report.iterations += before;
  return report;
}

/// Of S A S y = S b with x = S y, from x on.
SolveReport MinResLinearSolver::solveScaled(const SystemMatrix& matrix, Lanczos& work, ConstRows b, Rows x, int most) {
  for (Vector* vector : {&work.unscaled, &work.right_side})
    if (vector->count() != b.count) vector->resize(b.count);
  copy(b, work.right_side);
  work.scales.multiply(work.right_side);
  norm_b_ = norm(work.right_side);
  const auto solve = [&](cg::Limits limits) {
    work.scales.divide(x);
    SolveReport report = solveFrom(matrix, work, work.right_side, x, limits);
    work.scales.multiply(x);
    report.relative_residual *= norm_b_;
    return report;
  };
  const auto left = [&] { return work.scales.divide(work.v); };
  SolveReport report = work.light.solveAll(matrix, {most, target(), terms_.stop}, relativeTarget(terms_), solve, left, x);
  report.relative_residual /= norm_b_;
  return report;
}

SolveReport MinResLinearSolver::solveFrom(const SystemMatrix& matrix, Lanczos& work, ConstRows b, Rows x, const cg::Limits& limits) {
  SolveReport report;
  double now = scaledResidual(matrix, work, b, x);
  report.relative_residual = now / norm_b_;
  if (!(now > limits.residual)) return report;
  for (;;) {
    const double before = now;
    report.stop = iterate(matrix, work, x, now, limits, report);
    if (report.stop == SolveStop::not_finite || report.stop == SolveStop::stopped) return report;
    // what the recurrence says differs from b - A x by round-off: the report gives the latter
    now = scaledResidual(matrix, work, b, x);
    report.relative_residual = now / norm_b_;
    if (report.stop != SolveStop::converged || now <= 1.1 * limits.residual) return report;
    report.stop = report.iterations == limits.iterations ? SolveStop::iteration_limit : SolveStop::stagnated;
    if (report.stop == SolveStop::iteration_limit || now > 0.5 * before) return report;
  }
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(min_res_linear_solver) {
  factory.add<stroma::MinResLinearSolver>("MinResLinearSolver",
                                          "minimal residuals: symmetric matrices, definite or not");
}
