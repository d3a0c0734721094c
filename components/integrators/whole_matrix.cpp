// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/integrators/whole_matrix.h"

#include <algorithm>
#include <cmath>

#include "framework/algebra/vector.h"

namespace stroma {

WholeMatrix::WholeMatrix(SystemMatrix& base) : MatrixView(base) {
  for (Vector* vector : {&residual_, &preconditioned_, &direction_, &product_}) vector->resize(base.rows());
}

SolveReport WholeMatrix::solve(LinearSolver& solver, ConstRows b, Rows x, const SolveTerms& terms) {
  constexpr double usual_residual = 1e-10;
  SolveReport report = solver.solve(base_, b, x, terms);
  const double norm_b = norm(b);
  if (!report.usable() || report.stop == SolveStop::breakdown || report.stop == SolveStop::zero_right_side) return report;
  base_.multiply(x, product_);
  copy(b, residual_);
  axpy(-1, product_, residual_);
  const double left = norm(residual_) / norm_b, goal = std::max(terms.relative_residual, usual_residual);
  if (left <= std::max(goal, 2 * report.relative_residual)) return report;
  SolveReport whole = iterate(solver, norm_b, goal, x, terms.stop);
  whole.iterations += report.iterations;
  whole.factored = report.factored;
  return whole;
}

/// From x and its residual. Where products show no positive energy the matrix is not definite; x is then what was reached.
SolveReport WholeMatrix::iterate(LinearSolver& solver, double norm_b, double goal, Rows x, StopToken stop) {
  constexpr int most_iterations = 1000;
  SolveReport report;
  double before = 0;
  clear(direction_);
  for (report.iterations = 0; report.iterations < most_iterations; ++report.iterations) {
    report.relative_residual = norm(residual_) / norm_b;
    if (report.relative_residual <= goal) return report;
    clear(preconditioned_);
    const SolveReport inner = solver.solve(base_, residual_, preconditioned_, {.stop = stop});
    if (report.stop = inner.stop; !inner.usable()) return report;
    const double now = dot(residual_, preconditioned_);
    xpay(preconditioned_, before > 0 ? now / before : 0, direction_);
    before = now;
    base_.multiply(direction_, product_);
    const double curvature = dot(direction_, product_);
    report.stop = SolveStop::not_definite;
    if (!(curvature > 0 && now > 0)) return report;
    axpy(now / curvature, direction_, x);
    axpy(-now / curvature, product_, residual_);
    report.stop = SolveStop::converged;
  }
  report.stop = SolveStop::iteration_limit;
  return report;
}

SolveReport solveWhole(LinearSolver& solver, SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms) {
  auto* const whole = dynamic_cast<WholeMatrix*>(&matrix);
  return whole ? whole->solve(solver, b, x, terms) : solver.solve(matrix, b, x, terms);
}

SolveReport solveWhole(LinearSolver& solver, SystemMatrix& matrix, std::span<const ConstRows> b, std::span<const Rows> x,
                       const SolveTerms& terms) {
  auto* const whole = dynamic_cast<WholeMatrix*>(&matrix);
  if (!whole) return solver.solveAll(matrix, b, x, terms);
  SolveReport all{.stop = SolveStop::zero_right_side};
  for (std::size_t i = 0; i < b.size(); ++i)
    if (!all.add(whole->solve(solver, b[i], x[i], terms))) break;
  return all;
}

void WholeIfNeeded::compile(System& system) {
  whole_.reset();
  for (const ForceField* field : system.forceFields())
    if (const Data* why = field->data().find("fluidOfElements"); why && !why->print().empty()) whole_.emplace(system.matrix());
}

}  // namespace stroma
