// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/algebra/direct_solver.h"

#include <algorithm>
#include <cmath>

namespace stroma {

void DirectSolver::declare(DataTable& table) {
  table.add("template", template_)
      .help("the form of matrix: any CompressedRowSparseMatrix; the solver works on 3x3 blocks");
  table.add("factorisations", factorisations_).help("how often numbers were factored so far").unit("-").output();
}

bool DirectSolver::answersLookup() const {
  const auto& components = node().components();
  return std::none_of(components.begin(), components.end(), [this](const auto& component) {
    const auto* user = dynamic_cast<const FactorUser*>(component.get());
    return user && user->usesFactorOf(*this);
  });
}

/// True when there was something new to analyse.
bool DirectSolver::analyseIfNew(const BlockMatrix& matrix, bool symmetric) {
  if (symmetric == symmetric_ && matrix.rowStart() == row_start_ && matrix.columns() == columns_) return false;
  symmetric_ = symmetric;
  row_start_ = matrix.rowStart();
  columns_ = matrix.columns();
  residual_.resize(matrix.rows());
  correction_.resize(matrix.rows());
  analyse(matrix, symmetric);
  return true;
}

bool DirectSolver::factor(SystemMatrix& matrix, SolveReport& report) {
  const BlockMatrix& a = matrix.assemble();
  const bool is_new = analyseIfNew(a, matrix.symmetric());
  if (!is_new && isCurrent(matrix)) return true;
  factored_ = false;
  report.factored = true;
  ++factorisations_;
  const auto bad =
      std::find_if(a.values().begin(), a.values().end(), [](double value) { return !std::isfinite(value); });
  if (bad != a.values().end()) {
    const Index slot = Index((bad - a.values().begin()) / 9);
    report.row = Index(std::upper_bound(row_start_.begin(), row_start_.end(), slot) - row_start_.begin()) - 1;
    report.stop = SolveStop::not_finite;
    return false;
  }
  const SolveStop stop = factorValues(a, report.row);
  factored_ = stop == SolveStop::converged;
  if (!factored_) report.stop = stop;
  key_ = matrix.key();
  return factored_;
}

double DirectSolver::residual(const BlockMatrix& matrix, ConstRows b, ConstRows x) {
  matrix.multiply(x, residual_);
  xpay(b, -1, residual_);
  return std::sqrt(dot(residual_, residual_));
}

SolveReport DirectSolver::solve(SystemMatrix& matrix, ConstRows b, Rows x) {
  SolveReport report;
  const double norm_b = std::sqrt(dot(b, b));
  if (norm_b == 0) {
    clear(x);
    report.stop = SolveStop::zero_right_side;
    return report;
  }
  report.iterations = 1;
  report.relative_residual = 1;
  if (!std::isfinite(norm_b)) {
    report.stop = SolveStop::not_finite;
    return report;
  }
  if (!factor(matrix, report)) return report;
  const BlockMatrix& a = matrix.assemble();
  applyFactors(b, x);
  double error = residual(a, b, x);
  if (error > 1e-10 * norm_b) {
    applyFactors(residual_, correction_);
    axpy(1, correction_, x);
    error = residual(a, b, x);
  }
  report.relative_residual = error / norm_b;
  // a factor without one right digit: the matrix is singular to round-off
  if (!(error < 0.1 * norm_b)) {
    report.stop = uselessFactor();
    clear(x);
  }
  return report;
}

}  // namespace stroma
