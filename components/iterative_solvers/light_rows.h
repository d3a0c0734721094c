// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "components/iterative_solvers/preconditioned_conjugate_gradients.h"

namespace stroma {

/// Rows whose error the |r| of all rows does not see: those of a body of 1e-10 kg beside one of a kilogram, say. With D the 3x3 diagonal
/// blocks of A, D^-1 r is the error of a row that nothing else moves. Such rows are left while
///
///   max |D^-1 r| > share max |x|,   share = max(1e-3, tolerance of the solve).
///
/// D is that of the matrix solved: one diagonal for each matrix of which a solve has converged, or what the solver preconditions by. A
/// block that is not positive definite, or is singular but for round-off, counts as its largest |entry|: |r| over that is no more than
/// the error. Rows with empty blocks are left out. Turns and places are measured together, each in its unit.
///
/// Nothing is looked at where an assembly costs more than 64 products, as of a body whose fluid couples all nodes, or is not known: there D
/// costs as much as solves do.
class LightRows {
 public:
  static constexpr double least_share = 1e-3;
  /// `tolerance`: |b - A x| / |b| at which the solve ended.
  bool areLeft(const SystemMatrix& matrix, double tolerance, ConstRows r, ConstRows x) {
    const double most = std::max(least_share, tolerance) * largest(x);
    const double left = largest(r);
    if (left == 0 || isDear(matrix)) return false;
    if (key_ != matrix.key()) take(matrix);
    if (!(bound_ * left > most)) return false;
    if (z_.count() != r.count) z_.resize(r.count);
    inverse_->apply(r, z_);
    return largest(z_) > most;
  }
  /// D^-1 of the matrix that areLeft() was last true for.
  const cg::BlockJacobi& inverse() const { return *inverse_; }
  /// D of the matrix with this key, and D^-1, as the solver preconditions by them. They stay where they are, and as they are until
  /// the next call.
  void know(const MatrixKey& key, const std::vector<double>& blocks, const cg::BlockJacobi& inverse) {
    known_key_ = key, known_blocks_ = &blocks, known_inverse_ = &inverse;
  }

  /// Solves by solve(limits), which goes on from x until |b - A x|, as it measures it, is at most limits.residual. Then to a tenth of
  /// that, and so on, while light rows are left in r = `left()`. What stops short of the limits of the scene has converged.
  template <class Solve, class Residual>
  SolveReport solveAll(const SystemMatrix& matrix, cg::Limits limits, double tolerance, Solve&& solve, Residual&& left, ConstRows x) {
    const double enough = 1.1 * limits.residual;
    int done = 0;
    for (;; limits.residual /= 10, limits.smallest_cosine = cg::Limits::of_other_units) {
      SolveReport report = solve(limits);
      done += report.iterations, limits.iterations -= report.iterations;
      report.iterations = done;
      const bool is_over = report.stop != SolveStop::converged && report.stop != SolveStop::stagnated;
      if (is_over || !(report.relative_residual <= enough)) return report;
      if (!areLeft(matrix, tolerance, left(), x)) {
        report.stop = SolveStop::converged;
        return report;
      }
      if (report.stop == SolveStop::converged && limits.iterations <= 0) report.stop = SolveStop::iteration_limit;
      if (report.stop != SolveStop::converged) return report;
    }
  }
  /// cg::preconditioned() so.
  template <class Product, class Precondition, class Record>
  SolveReport conjugateGradients(const SystemMatrix& matrix, Product&& product, Precondition&& precondition, Record&& record,
                                 const cg::Limits& limits, double tolerance, ConstRows b, cg::Directions& work, Rows x, bool has_residual,
                                 bool has_step) {
    const auto solve = [&](const cg::Limits& now) {
      const SolveReport report = cg::preconditioned(product, precondition, record, now, b, work, x, has_residual, has_step);
      has_residual = true, has_step = false;
      return report;
    };
    return solveAll(matrix, limits, tolerance, solve, [&] { return work.r.rows(); }, x);
  }

 private:
  static bool isDear(const SystemMatrix& matrix) {
    constexpr double most_products = 64;
    const double product = matrix.productCost();
    return product > 0 && matrix.assemblyCost() > most_products * product;
  }
  static double largest(ConstRows rows) {
    double most = 0;
#pragma omp simd reduction(max : most)
    for (std::size_t i = 0; i < rows.doubles(); ++i) most = std::max(most, std::abs(rows.data[i]));
    return most;
  }
  using Block = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  void take(const SystemMatrix& matrix) {
    key_ = matrix.key();
    inverse_ = known_key_ == key_ && areClearlyDefinite(*known_blocks_) ? known_inverse_ : makeOwn(matrix);
    bound_ = 3 * inverse_->largest();
  }
  const cg::BlockJacobi* makeOwn(const SystemMatrix& matrix) {
    matrix.diagonalBlocks(blocks_);
    for (std::size_t at = 0; at < blocks_.size(); at += 9) {
      Eigen::Map<Block> block(blocks_.data() + at);
      if (!isClearlyDefinite(block)) block = Mat3(sizeOf(block) * Mat3::Identity());
    }
    own_.factor(blocks_);
    return &own_;
  }
  static bool areClearlyDefinite(const std::vector<double>& blocks) {
    for (std::size_t at = 0; at < blocks.size(); at += 9)
      if (!isClearlyDefinite(Eigen::Map<const Block>(blocks.data() + at))) return false;
    return true;
  }
  /// What a block counts for that has no inverse to rely on: its largest |entry|, or so much that its row is left out. The cubes of both
  /// are numbers.
  static double sizeOf(const Mat3& block) {
    constexpr double least = 1e-100, most = 1e100;
    const double size = block.cwiseAbs().maxCoeff();
    return size >= least && size <= most ? size : most;
  }
  /// Whether the pivots of elimination are positive, and above what round-off makes of a zero.
  static bool isClearlyDefinite(const Mat3& a) {
    constexpr double noise = 1e-14;
    const double least = noise * a.cwiseAbs().maxCoeff(), minor = a(0, 0) * a(1, 1) - a(0, 1) * a(1, 0);
    return a(0, 0) > least && minor > least * a(0, 0) && a.determinant() > least * minor;
  }

  const cg::BlockJacobi* inverse_ = nullptr;  ///< D^-1: own_, or what is known
  MatrixKey key_;                             ///< of D
  double bound_ = 0;                          ///< on the largest |(D^-1 r)_i| / max |r_i|
  cg::BlockJacobi own_;
  std::vector<double> blocks_;  ///< of that
  MatrixKey known_key_;
  const std::vector<double>* known_blocks_ = nullptr;
  const cg::BlockJacobi* known_inverse_ = nullptr;
  Vector z_;  ///< D^-1 r
};

}  // namespace stroma
