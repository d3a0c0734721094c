// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/integrators/soft_directions.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Eigenvalues>

#include "components/integrators/whole_matrix.h"

namespace stroma {
namespace {

/// An orthonormal basis v of a Krylov space of (A + s D)^-1 D, in the product u.D v, and w = (A + s D)^-1 D v.
struct Krylov {
  std::vector<Vector> v, w;
  const std::vector<double>& d;  ///< D, one number for each row
  SolveStop stop = SolveStop::converged;  ///< of the last solve

  double product(ConstRows a, ConstRows b) const {
    double sum = 0;
    for (Index row = 0; row < a.count; ++row) sum += d[std::size_t(row)] * a[row].dot(b[row]);
    return sum;
  }
  /// Adds `next` without what the basis has of it. False: nothing is left.
  bool add(ConstRows next) {
    constexpr double nothing = 1e-10;
    Vector one(next.count);
    copy(next, one);
    const double before = std::sqrt(product(one, one));
    for (int twice = 0; twice < 2; ++twice)
      for (const Vector& other : v) axpy(-product(other, one), other, one);
    const double left = std::sqrt(product(one, one));
    if (!(left > nothing * before) || !std::isfinite(left)) return false;
    scale(1 / left, one);
    v.push_back(std::move(one));
    return true;
  }
};

/// Of A^-1 D, or with a shift: its Krylov space from `first`, at most `most` vectors. False: a solve failed or was stopped.
bool build(Krylov& krylov, std::size_t most, ConstRows first, LinearSolver& solver, SystemMatrix& matrix, const SolveTerms& terms,
           StepReport& report) {
  Vector right(first.count);
  for (ConstRows next = first; krylov.v.size() < most && krylov.add(next); next = krylov.w.back()) {
    copy(krylov.v.back(), right);
    for (Index row = 0; row < right.count(); ++row) right[row] *= krylov.d[std::size_t(row)];
    Vector found(right.count());
    clear(found);
    const SolveReport solve = solveWhole(solver, matrix, right, found, terms);
    report.factorisations += solve.factored;
    krylov.stop = solve.stop;
    if (solve.stop != SolveStop::converged) {
      report.stopped = report.stopped || solve.stop == SolveStop::stopped;
      return false;
    }
    krylov.w.push_back(std::move(found));
  }
  return true;
}

Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> ritz(const Krylov& krylov) {
  const Eigen::Index size = Eigen::Index(krylov.w.size());
  Eigen::MatrixXd inverse(size, size);
  for (Eigen::Index i = 0; i < size; ++i)
    for (Eigen::Index j = 0; j < size; ++j) inverse(i, j) = krylov.product(krylov.v[std::size_t(i)], krylov.w[std::size_t(j)]);
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(0.5 * (inverse + inverse.transpose()));
}

}  // namespace

void restoreSoftDirections(LinearSolver& solver, ShiftedMatrix& shifted, double shift, ConstRows r, Rows d, const SolveTerms& terms,
                           StepReport& report) {
  constexpr std::size_t most = 8;
  constexpr double least_part = 1e-3;  // of the shift, where l is next to nothing: the line search finds how far that is
  if (!shifted.symmetric()) return;
  Krylov krylov{{}, {}, shifted.scale()};
  if (!build(krylov, most, d, solver, shifted, terms, report) || krylov.w.empty()) return;
  const auto found = ritz(krylov);
  const Eigen::Index size = found.eigenvalues().size();
  for (Eigen::Index k = 0; k < size; ++k) {
    const double mu = found.eigenvalues()[k];
    if (!(mu > 0)) continue;  // round-off: A + s D is positive
    const double l = 1 / mu - shift, larger = 1 / std::max(std::abs(l), least_part * shift) - mu;
    if (l > shift) continue;
    double work = 0;
    for (Eigen::Index i = 0; i < size; ++i) work += found.eigenvectors()(i, k) * dot(r, krylov.v[std::size_t(i)]);
    for (Eigen::Index i = 0; i < size; ++i) axpy(work * larger * found.eigenvectors()(i, k), krylov.v[std::size_t(i)], d);
  }
}

bool hasUnstableMode(LinearSolver& solver, SystemMatrix& matrix, const SolveTerms& terms, StepReport& report) {
  constexpr double round_off = 1e-8;
  if (!matrix.symmetric()) return false;
  const std::size_t most = solver.needsSymmetric() ? 1 : 10;
  std::vector<double> blocks, d(std::size_t(matrix.rows()));
  matrix.diagonalBlocks(blocks);
  for (std::size_t i = 0; i < d.size(); ++i)
    d[i] = std::max((std::abs(blocks[9 * i]) + std::abs(blocks[9 * i + 4]) + std::abs(blocks[9 * i + 8])) / 3, 1e-300);
  Vector first(matrix.rows());  // has a part in every mode: symmetric loads have none in many that are unstable
  for (Index row = 0; row < first.count(); ++row)
    for (int c = 0; c < 3; ++c) first[row][c] = std::sin(1.7 * double(3 * row + c) + 0.3 * double(row % 7));
  Krylov krylov{{}, {}, d};
  const bool is_built = build(krylov, most, first, solver, matrix, terms, report);
  if (krylov.stop == SolveStop::not_definite) return true;
  if (!is_built || krylov.w.empty()) return false;
  const auto found = ritz(krylov);
  return found.eigenvalues()[0] < -round_off * found.eigenvalues().cwiseAbs().maxCoeff();
}

}  // namespace stroma
