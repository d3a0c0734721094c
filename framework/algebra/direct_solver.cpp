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
  table.add("factorisations", factorisations_).help("number of factorisations so far, of all matrices").unit("-").output();
}

bool DirectSolver::answersLookup() const {
  const auto& components = node().components();
  return std::none_of(components.begin(), components.end(), [this](const auto& component) {
    const auto* user = dynamic_cast<const FactorUser*>(component.get());
    return user && user->usesFactorOf(*this);
  });
}

bool DirectSolver::update(SystemMatrix& matrix, Kept& kept, SolveReport& report, StopToken stop) {
  const BlockMatrix& a = matrix.assemble();
  const MatrixKey key = matrix.key();
  const bool symmetric = matrix.symmetric();
  report.stop = SolveStop::stopped;
  if (stop.isStopAsked()) return false;
  if (!kept.analysed.matrix || kept.analysed.pattern != key.pattern || kept.symmetric != symmetric) {
    kept.analysed = {}, kept.factored = false;
    if (!kept.factors || kept.symmetric != symmetric) kept.factors = makeFactorisation(symmetric);
    kept.symmetric = symmetric;
    const Span span("analyse", this);
    if (!kept.factors->analyse(a, stop)) return false;
    for (Vector* vector : {&kept.residual, &kept.correction}) vector->resize(a.rows());
    kept.analysed = key;
  }
  report.stop = SolveStop::converged;
  if (kept.factored && kept.key == key) return true;
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
  kept.key = key;
  return kept.factored;
}

Factorisation* DirectSolver::factor(SystemMatrix& matrix, SolveReport& report, StopToken stop) {
  Kept& kept = kept_.of(matrix);
  return update(matrix, kept, report, stop) ? kept.factors.get() : nullptr;
}

void DirectSolver::handOver(SystemMatrix& former, SystemMatrix& matrix) {
  Kept& from = kept_.of(former);
  Kept& to = kept_.of(matrix);
  if (!from.factors || to.factors) return;
  to.factors = std::move(from.factors);
  to.symmetric = from.symmetric;
  from = {};
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
    if (!(now < error)) axpy(-1, kept.correction, x);
    const bool halves = now < 0.5 * error;
    error = std::min(error, now);
    if (!halves) break;
  }
  return error;
}

void Factorisation::applyAll(std::span<const ConstRows> b, std::span<const Rows> x) {
  for (std::size_t i = 0; i < b.size(); ++i) apply(b[i], x[i]);
}

/// x of the factors is refined and judged.
SolveReport DirectSolver::finish(const BlockMatrix& a, ConstRows b, Rows x, Kept& kept) const {
  const double norm_b = norm(b);
  if (norm_b == 0) return clear(x), SolveReport{.stop = SolveStop::zero_right_side};
  const double error = refine(a, b, norm_b, x, kept);
  SolveReport report{.iterations = 1, .relative_residual = error / norm_b};
  if (error > most_of_right_side * norm_b && !givesLeastSquares()) report.stop = SolveStop::stagnated;
  // a factor without one right digit: the matrix is singular to round-off
  if (!(error < 0.1 * norm_b)) {
    report.stop = uselessFactor();
    givesLeastSquares() ? kept.factors->apply(b, x) : clear(x);
  }
  return report;
}

SolveReport DirectSolver::solveAll(SystemMatrix& matrix, std::span<const ConstRows> b, std::span<const Rows> x, const SolveTerms& terms) {
  SolveReport report{.stop = SolveStop::zero_right_side};
  const auto clearAll = [x] { std::for_each(x.begin(), x.end(), [](Rows each) { clear(each); }); };
  double size = 0;  // not finite where one is not
  for (const ConstRows& each : b) size += norm(each);
  if (size == 0) return clearAll(), report;
  Kept& kept = kept_.of(matrix);
  report = {.stop = SolveStop::not_finite, .iterations = 1, .relative_residual = 1};
  if (!std::isfinite(size) || !update(matrix, kept, report, terms.stop)) return report;
  const BlockMatrix& a = matrix.assemble();
  kept.factors->applyAll(b, x);
  if (terms.stop.isStopAsked()) return clearAll(), report.stop = SolveStop::stopped, report;  // factors given up solve nothing
  report = {.stop = SolveStop::zero_right_side, .factored = report.factored};
  for (std::size_t i = 0; i < b.size(); ++i) report.add(finish(a, b[i], x[i], kept));
  return report;
}

}  // namespace stroma
