// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/algebra/direct_solver.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "framework/scene/spans.h"

namespace stroma {

/// Large fronts of single precision run at 115 Gflop/s on one core, of double at 40; numbers are cleared, added and divided besides.
/// Fitted to 1,331 nodes of tetrahedra, and to 1,331 and 15,625 of hexahedra. An application reads them twice, from the caches or from
/// memory where there are 25 MB of them (in nine bodies): 0.1 ns a byte more, so that numbers of double precision cost twice that.
Factorisation::Cost Factorisation::Cost::of(double entries, double flops, bool in_single) {
  const double bytes = in_single ? 4 : 8, far = 0.1e-9 * bytes * std::clamp((1e-6 * bytes * entries - 10) / 15, 0.0, 1.0);
  if (in_single) return {flops / 115e9 + 2.3e-9 * entries, (0.33e-9 + far) * entries};
  return {flops / 40e9 + 8e-9 * entries, (0.65e-9 + far) * entries};
}

void DirectSolver::declare(DataTable& table) {
  table.add("template", template_).help("the form of matrix: any CompressedRowSparseMatrix; the solver works on 3x3 blocks");
  table.add("factorisations", factorisations_).help("how often numbers were factored so far, of all matrices").unit("-").output();
}

bool DirectSolver::answersLookup() const {
  const auto& components = node().components();
  return std::none_of(components.begin(), components.end(), [this](const auto& component) {
    const auto* user = dynamic_cast<const FactorUser*>(component.get());
    return user && user->usesFactorOf(*this);
  });
}

bool DirectSolver::analyseIfNew(const SystemMatrix& matrix, const BlockMatrix& values, Kept& kept, StopToken stop) const {
  const MatrixKey key = matrix.key();
  const bool symmetric = matrix.symmetric();
  if (kept.analysed.matrix && kept.analysed.pattern == key.pattern && kept.symmetric == symmetric) return true;
  kept.analysed = {};
  kept.factored = false;
  if (!kept.factors || kept.symmetric != symmetric) kept.factors = makeFactorisation(symmetric);
  kept.symmetric = symmetric;
  const Span span("analyse", this);
  if (!kept.factors->analyse(values, stop)) return false;
  for (Vector* vector : {&kept.residual, &kept.correction}) vector->resize(values.rows());
  kept.analysed = key;
  return true;
}

bool DirectSolver::update(SystemMatrix& matrix, Kept& kept, SolveReport& report, StopToken stop) {
  const BlockMatrix& a = matrix.assemble();
  if (stop.isStopAsked() || !analyseIfNew(matrix, a, kept, stop)) {
    report.stop = SolveStop::stopped;
    return false;
  }
  if (kept.factored && kept.key == matrix.key()) return true;
  kept.factored = false;
  report.factored = true;
  ++factorisations_;
  const auto bad = std::find_if(a.values().begin(), a.values().end(), [](double value) { return !std::isfinite(value); });
  if (bad != a.values().end()) {
    const Index slot = Index((bad - a.values().begin()) / 9);
    report.row = Index(std::upper_bound(a.rowStart().begin(), a.rowStart().end(), slot) - a.rowStart().begin()) - 1;
    report.stop = SolveStop::not_finite;
    return false;
  }
  const Span span("factor", this);
  kept.factors->load(a);
  const SolveStop end = kept.factors->factor(report.row, stop);
  if (end != SolveStop::stopped) noteFactored(*kept.factors);
  kept.factored = end == SolveStop::converged;
  if (!kept.factored) report.stop = end;
  kept.key = matrix.key();
  return kept.factored;
}

Factorisation* DirectSolver::factor(SystemMatrix& matrix, SolveReport& report, StopToken stop) {
  Kept& kept = kept_.of(matrix);
  return update(matrix, kept, report, stop) ? kept.factors.get() : nullptr;
}

Factorisation* DirectSolver::factorValues(SystemMatrix& matrix, const std::vector<double>& values, StopToken stop) {
  BlockMatrix former = matrix.pattern();
  if (former.values().size() != values.size()) return nullptr;
  former.values() = values;
  Kept& kept = kept_.of(matrix);
  if (!analyseIfNew(matrix, former, kept, stop)) return nullptr;
  kept.factored = false;
  kept.factors->load(former);
  Index row = -1;
  return kept.factors->factor(row, stop) == SolveStop::converged ? kept.factors.get() : nullptr;
}

namespace {

/// r = b - A x; returns its norm.
double residual(const BlockMatrix& a, ConstRows b, ConstRows x, Rows r) {
  a.multiply(x, r);
  xpay(b, -1, r);
  return norm(r);
}

/// What a solve may leave of its right side |b| [-]. A single refinement brings nearly every matrix to round-off; more
/// are worth their products only where a loss would be seen, and what is left then is told.
constexpr double worth_one = 1e-10, worth_more = 1e-8, most_of_right_side = 1e-5;
constexpr int most_refinements = 8;

}  // namespace

/// x of `factors` is corrected by its residual while that halves it; returns |b - A x|.
double DirectSolver::refine(const BlockMatrix& a, ConstRows b, double norm_b, Rows x, Kept& kept) const {
  double error = residual(a, b, x, kept.residual);
  for (int k = 0; k < most_refinements && error > (k == 0 ? worth_one : worth_more) * norm_b; ++k) {
    kept.factors->apply(kept.residual, kept.correction);
    axpy(1, kept.correction, x);
    const double now = residual(a, b, x, kept.residual);
    if (!(now < error)) {
      axpy(-1, kept.correction, x);
      break;
    }
    const bool halves = now < 0.5 * error;
    error = now;
    if (!halves) break;
  }
  return error;
}

SolveReport DirectSolver::solve(SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms) {
  SolveReport report;
  const double norm_b = norm(b);
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
  Kept& kept = kept_.of(matrix);
  if (!update(matrix, kept, report, terms.stop)) return report;
  const BlockMatrix& a = matrix.assemble();
  Factorisation& factors = *kept.factors;
  factors.apply(b, x);
  const double error = refine(a, b, norm_b, x, kept);
  report.relative_residual = error / norm_b;
  if (error > most_of_right_side * norm_b && !givesLeastSquares()) report.stop = SolveStop::stagnated;
  // a factor without one right digit: the matrix is singular to round-off
  if (!(error < 0.1 * norm_b)) {
    report.stop = uselessFactor();
    givesLeastSquares() ? factors.apply(b, x) : clear(x);
  }
  return report;
}

}  // namespace stroma
