// SPDX-License-Identifier: LGPL-2.1-or-later
// A nearly incompressible body: displacements u and pressures p are solved for together, so that nothing grows with the
// bulk modulus. The matrix is K = A + B^T E B. B has a row for each volume (VolumeTerms), the diagonal matrix E is what its
// bulk modulus exceeds that of Poisson's ratio 0.3, and A is the matrix of a compressible body. With p = E B u,
//
//   | A    B^T  | | u |   | f |
//   | B  -E^-1  | | p | = | 0 |.
//
// Flexible GMRES (Saad 1993) solves it, preconditioned from the right by a block triangle (Murphy, Golub, Wathen 2000)
//
//   p = -T r_p,   u = V (r_u - B^T p).
//
// V ~ A^-1 is a V-cycle of multigrid_hierarchy.h, in single precision. T ~ (B A^-1 B^T)^-1 is the scaled BFBt or
// least-squares commutator (Elman 1999; Elman, Howle, Shadid, Shuttleworth, Tuminaro 2006; for jumps of stiffness May, Moresi 2008),
//
//   T = X^-1 (B D^-1 A D^-1 B^T + L E L) X^-1,   X = B D^-1 B^T + L,   D the diagonal blocks of A.
//
// L ~ E^-1 D_p^-1 A_p is E^-1 times a Laplacian of the pressures that is 0 for smooth ones and about 1 for rough ones. For a
// pressure with B D^-1 B^T = x and D^-1 A = a, T is then a / (x + a E^-1), the inverse of x / a + E^-1. Without L, iterations at
// Poisson's ratio 0.499 double from 10^3 to 30^3 cells. L = sum_i l_i (n_i I - 1 1^T) over the nodes i with n_i pressures.
//
// Hexahedra with one pressure each have pressures, near a chessboard pattern, that hardly act on a displacement. T knows them: the
// eigenvalues of T B A^-1 B^T are 1 to 1.64 with 10^3 cells and 1 to 1.8 with 14^3. With a mass matrix for T they are 0.007 to
// 1.6 with 10^3 cells, and iterations grow with the mesh. X is factored. It has a number for each pressure: with as many pressures
// as nodes its factors take 1/27 of the operations of those of K, and 1/9 of the memory. Three pressures make a row, neighbours
// first, so that X is a matrix of 3x3 blocks.
//
// Iterations end when |f - K u|, computed, is small enough. Minimising that norm itself would not do: K times what single precision
// rounds in V is as large as the residual.
#pragma once
#include <memory>

#include "components/iterative_solvers/gmres.h"
#include "components/iterative_solvers/multigrid_hierarchy.h"
#include "framework/algebra/direct_solver.h"
#include "framework/algebra/volume_terms.h"

namespace stroma {

/// Volumes whose pressures are unknowns.
class PressureRows {
 public:
  /// Takes the terms whose bulk modulus is far above the shear modulus.
  PressureRows(const VolumeTerms& terms, Index nodes);
  bool empty() const { return excess_.empty(); }
  /// Of the volume as a row of three pressures each.
  Index rows() const { return rows_; }
  Index count() const { return Index(excess_.size()); }
  /// K becomes A = K - B^T E B.
  void subtractFrom(BlockMatrix& k) const;
  /// out = L p; `sums` has a row for each node.
  void multiplyByLaplacian(ConstRows p, Rows sums, Rows out) const;
  /// The pattern and the values of X.
  BlockMatrix products(const std::vector<Mat3>& inverse) const;
  /// out = B u
  void volumes(ConstRows u, Rows out) const;
  /// out += factor B^T p
  void addForces(double factor, ConstRows p, Rows out) const;
  /// p = E p, and p = E^-1 p
  void multiplyByExcess(Rows p) const;
  void divideByExcess(Rows p) const;

 private:
  void group();
  void weighLaplacian();

  std::vector<Index> start_{0}, nodes_;
  std::vector<Vec3> gradients_;
  std::vector<double> excess_;
  std::vector<std::size_t> place_;       ///< of a pressure among the numbers of a vector of rows(); shape (count)
  std::vector<Index> entry_start_, entries_, volume_of_;  ///< the entries of each node, and whose they are
  std::vector<double> laplacian_;  ///< l_i of each node
  Index rows_ = 0;
};

/// One for each matrix.
class MixedSolve {
 public:
  MixedSolve();
  ~MixedSolve();
  static constexpr int most_iterations = 150;  ///< of a solve: cubes take 30, and one that takes more hardly ends
  /// Brings everything up to date with the matrix. False: the report says why.
  bool follow(SystemMatrix& matrix, const VolumeTerms& terms, DirectSolver& factors, SolveReport& report, StopToken stop);
  bool isOf(const SystemMatrix& matrix) const { return factors_ && key_ == matrix.key(); }
  void reset();

  /// Solves K x = b from the x given, see gmres::solve(); product(p, out) is that of K.
  template <class Product, class Record>
  SolveReport solve(Product&& product, Record&& record, const cg::Limits& limits, ConstRows b, Rows x);

 private:
  struct Pressures;  ///< X as the matrix of a direct solver

  static constexpr std::size_t restart = 60;

  Vector& vectorOf(std::vector<Vector>& vectors, std::size_t i) {
    while (vectors.size() <= i) vectors.emplace_back().resize(both_.count());
    return vectors[i];
  }
  template <class Product>
  void multiply(Product&& product, ConstRows in, Rows out);
  template <class Product>
  void precondition(Product&& product, ConstRows r, Rows z);
  template <class Product, class Record>
  SolveStop descend(Product&& product, Record&& record, const cg::Limits& limits, ConstRows b, double now, SolveReport& report);
  template <class Product>
  void applyInverseSchur(Product&& product, ConstRows r, Rows p);

  MatrixKey key_;
  double weight_ = 1;  ///< of the lower part of the residual [N/m^3]
  Index nodes_ = 0;
  std::unique_ptr<PressureRows> volumes_;
  std::shared_ptr<amg::Hierarchy> hierarchy_;
  cg::BlockJacobi diagonal_;
  std::unique_ptr<Pressures> matrix_;
  Factorisation* factors_ = nullptr;
  std::vector<Vector> basis_, steps_;  ///< each of displacements, then pressures
  Vector both_, trial_, forces_, moved_, pressures_, sums_;
};

/// p = T r; r is in pressures_, which changes.
template <class Product>
void MixedSolve::applyInverseSchur(Product&& product, ConstRows r, Rows p) {
  factors_->applyRoughly(r, sums_);
  copy(sums_, pressures_);  // r is not read again
  clear(forces_);
  volumes_->addForces(1, pressures_, forces_);
  diagonal_.apply(forces_, moved_);
  product(moved_.rows(), forces_.rows());  // A = K - B^T E B
  volumes_->volumes(moved_, sums_);
  volumes_->multiplyByExcess(sums_);
  volumes_->addForces(-1, sums_, forces_);
  volumes_->multiplyByLaplacian(pressures_, moved_, sums_);
  volumes_->multiplyByExcess(sums_);
  volumes_->multiplyByLaplacian(sums_, moved_, pressures_);
  diagonal_.apply(forces_, moved_);
  volumes_->volumes(moved_, sums_);
  axpy(1, pressures_, sums_);
  factors_->applyRoughly(sums_, p);
}

/// out = (A u + B^T p, weight (B u - E^-1 p)), A = K - B^T E B
template <class Product>
void MixedSolve::multiply(Product&& product, ConstRows in, Rows out) {
  const Index rows = volumes_->rows();
  const Rows above = out.head(nodes_), below = out.segment(nodes_, rows);
  product(in.head(nodes_), above);
  volumes_->volumes(in.head(nodes_), below);
  copy(in.segment(nodes_, rows), pressures_), copy(below, sums_);
  volumes_->multiplyByExcess(sums_);
  axpy(-1, sums_, pressures_);
  volumes_->addForces(1, pressures_, above);
  volumes_->divideByExcess(pressures_);
  copy(pressures_, below);
  scale(-weight_, below);
}

/// z = (V (r_u - B^T p), p), p = -T r_p
template <class Product>
void MixedSolve::precondition(Product&& product, ConstRows r, Rows z) {
  const Rows p = z.segment(nodes_, volumes_->rows());
  copy(r.segment(nodes_, volumes_->rows()), pressures_);
  scale(-1 / weight_, pressures_);
  applyInverseSchur(product, pressures_, p);
  copy(r.head(nodes_), forces_);
  volumes_->addForces(-1, p, forces_);
  hierarchy_->apply(forces_, z.head(nodes_));
}

/// One space: from x and p in both_ to the better ones. False: it cannot go on.
template <class Product, class Record>
SolveStop MixedSolve::descend(Product&& product, Record&& record, const cg::Limits& limits, ConstRows b, double now, SolveReport& report) {
  Vector& first = vectorOf(basis_, 0);
  const double beta = norm(first);
  if (!(beta > 0) || !std::isfinite(beta)) return beta == 0 ? SolveStop::converged : SolveStop::not_finite;
  scale(1 / beta, first);
  gmres::Triangle triangle(beta);
  double check = beta * std::min(0.5, limits.residual / now);
  for (;;) {
    if (limits.stop.isStopAsked()) return SolveStop::stopped;
    const std::size_t j = triangle.size();
    Vector &step = vectorOf(steps_, j), &next = vectorOf(basis_, j + 1);
    precondition(product, basis_[j], step);
    multiply(product, step, next);
    ++report.iterations;
    std::vector<double> column;
    for (std::size_t i = 0; i <= j; ++i) {
      column.push_back(cg::inner(next, basis_[i]));
      axpy(-column[i], basis_[i], next);
    }
    const double length = norm(next);
    if (!std::isfinite(length)) return SolveStop::not_finite;
    if (!triangle.add(std::move(column), length)) return SolveStop::breakdown;
    if (length > 0) scale(1 / length, next);
    record(report.relative_residual * std::min(1.0, triangle.residual() / beta));
    const bool is_full = triangle.size() == restart || report.iterations >= limits.iterations || length == 0;
    if (!is_full && triangle.residual() > check) continue;
    copy(both_, trial_);
    const std::vector<double> y = triangle.solution();
    for (std::size_t i = 0; i < y.size(); ++i) axpy(y[i], steps_[i], trial_);
    product(trial_.rows().head(nodes_), moved_.rows());
    copy(b, forces_);
    const double left = std::sqrt(cg::reduceResidual(1, moved_, forces_));
    if (left > limits.residual && !is_full) {
      check = triangle.residual() * std::clamp(0.9 * limits.residual / left, 0.01, 0.5);
      continue;
    }
    std::swap(both_, trial_);
    report.relative_residual = left;
    return SolveStop::converged;
  }
}

template <class Product, class Record>
SolveReport MixedSolve::solve(Product&& product, Record&& record, const cg::Limits& limits, ConstRows b, Rows x) {
  constexpr double least_gain = 0.5;  // of a whole space
  const Index rows = volumes_->rows();
  SolveReport report;
  clear(both_);
  copy(x, both_.head(nodes_));
  for (double before = std::numeric_limits<double>::infinity();;) {
    // p = E B u: then the lower part of the residual is zero, and the upper one is that of K
    const Rows pressures = both_.rows().segment(nodes_, rows);
    volumes_->volumes(both_.head(nodes_), pressures);
    volumes_->multiplyByExcess(pressures);
    Vector& r = vectorOf(basis_, 0);
    clear(r);
    product(both_.rows().head(nodes_), moved_.rows());
    copy(b, r.head(nodes_));
    const double now = report.relative_residual = std::sqrt(cg::reduceResidual(1, moved_, r.head(nodes_)));
    report.stop = !std::isfinite(now)                        ? SolveStop::not_finite
                  : now <= limits.residual                   ? SolveStop::converged
                  : report.iterations >= limits.iterations   ? SolveStop::iteration_limit
                  : now > least_gain * before                ? SolveStop::stagnated
                                                             : SolveStop::breakdown;
    if (report.stop == SolveStop::breakdown) {
      before = now;
      report.stop = descend(product, record, limits, b, now, report);
      if (report.stop == SolveStop::converged) continue;
    }
    copy(both_.head(nodes_), x);
    return report;
  }
}

}  // namespace stroma
