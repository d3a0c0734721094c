// SPDX-License-Identifier: LGPL-2.1-or-later
// Preconditioners made of sweeps over the 3x3 blocks of a matrix. Inline for the reason given in vector.h.
#pragma once
#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "components/iterative_solvers/conjugate_gradients.h"
#include "components/iterative_solvers/preconditioner.h"

namespace stroma {

/// A block of a BlockMatrix as it is stored, row-major.
using RowBlock = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
/// Block `slot` of values of shape (blocks, 9): a view, valid while the values live.
inline Eigen::Map<const RowBlock> blockAt(const std::vector<double>& values, Index slot) {
  return Eigen::Map<const RowBlock>(values.data() + std::size_t(slot) * 9);
}
inline Eigen::Map<RowBlock> blockAt(std::vector<double>& values, Index slot) {
  return Eigen::Map<RowBlock>(values.data() + std::size_t(slot) * 9);
}

/// Follows the key of a matrix, so that an inverse is made again only when values may have changed.
class FollowingInverse : public ApproximateInverse {
 public:
  const MatrixKey& key() const { return key_; }  ///< of the matrix that it is of
  /// Brings the inverse up to date; false when the matrix has none, and the report says at which row.
  bool follow(SystemMatrix& matrix, SolveReport& report, StopToken) final {
    if (key_ == matrix.key()) {
      look(matrix);
      return true;
    }
    reset();
    if (!make(matrix, report)) return false;
    key_ = matrix.key();
    return true;
  }
  void reset() override { key_ = {}; }

 protected:
  /// Makes the inverse anew for the present values. False after refuse().
  virtual bool make(SystemMatrix& matrix, SolveReport& report) = 0;
  /// The numbers are the same, the object that shows them may be another.
  virtual void look(SystemMatrix&) {}
  /// Not positive definite, seen at this row: the solver stops with a sentence that names its node.
  static bool refuse(Index row, SolveReport& report) {
    report.stop = SolveStop::not_definite;
    report.row = row;
    return false;
  }

 private:
  MatrixKey key_;  ///< of the inverse
};

/// B = diag(A)^-1.
class Jacobi final : public FollowingInverse {
 public:
  void apply(ConstRows r, Rows z) override {
    const double* __restrict d = inverse_.rows().data;
    for (std::size_t i = 0; i < r.doubles(); ++i) z.data[i] = d[i] * r.data[i];
  }

 protected:
  bool make(SystemMatrix& matrix, SolveReport& report) override {
    matrix.diagonalBlocks(blocks_);
    if (inverse_.count() != matrix.rows()) inverse_.resize(matrix.rows());
    for (Index row = 0; row < matrix.rows(); ++row)
      for (int c = 0; c < 3; ++c) {
        const double value = blocks_[9 * std::size_t(row) + 4 * std::size_t(c)];
        if (!(value > 0)) return refuse(row, report);
        inverse_[row][c] = 1 / value;
      }
    return true;
  }

 private:
  /// Diagonal blocks as they came, shape (rows, 9); kept for the room.
  std::vector<double> blocks_;
  /// 1 / a_ii, shape (rows); the fourth number of a row stays zero.
  Vector inverse_;
};

/// B = (block diagonal of A)^-1, blocks of a node.
class BlockJacobiInverse final : public FollowingInverse {
 public:
  void apply(ConstRows r, Rows z) override { jacobi_.apply(r, z); }
  const BlockJacobiInverse* blockJacobi() const override { return this; }
  const std::vector<double>& blocks() const { return blocks_; }
  const cg::BlockJacobi& inverse() const { return jacobi_; }

 protected:
  bool make(SystemMatrix& matrix, SolveReport& report) override {
    matrix.diagonalBlocks(blocks_);
    const Index bad = jacobi_.factor(blocks_);
    return bad < 0 || refuse(bad, report);
  }

 private:
  std::vector<double> blocks_;
  cg::BlockJacobi jacobi_;
};

/// The sum of the blocks [first, last) of a row times z.
inline Vec3 sumOfBlocks(const BlockMatrix& matrix, ConstRows z, Index first, Index last) {
  const double* __restrict v = matrix.values().data();
  double s0 = 0, s1 = 0, s2 = 0;
  for (Index s = first; s < last; ++s) {
    const double* m = v + std::size_t(s) * 9;
    const double* p = z.data + std::size_t(matrix.columns()[s]) * row_doubles;
    s0 += m[0] * p[0] + m[1] * p[1] + m[2] * p[2];
    s1 += m[3] * p[0] + m[4] * p[1] + m[5] * p[2];
    s2 += m[6] * p[0] + m[7] * p[1] + m[8] * p[2];
  }
  return {s0, s1, s2};
}

/// Symmetric successive over-relaxation with A = L + D + L^T, D the blocks of the nodes (Axelsson 1996, section 7.4):
///   B^-1 = 1 / (w (2 - w)) (D + w L) D^-1 (D + w L^T).
class Ssor final : public FollowingInverse {
 public:
  /// `omega` in (0, 2); 1 is symmetric Gauss-Seidel.
  explicit Ssor(double omega = 1) : omega_(omega) {}

  void apply(ConstRows r, Rows z) override {
    const BlockMatrix& a = *matrix_;
    const Index rows = a.rows();
    const double factor = omega_ * (2 - omega_);
    for (Index i = 0; i < rows; ++i)
      z[i] = inverse_[i] * (factor * r[i] - omega_ * sumOfBlocks(a, z, a.rowStart()[i], a.diagonal()[i]));
    for (Index i = rows - 1; i >= 0; --i)
      z[i] -= omega_ * (inverse_[i] * sumOfBlocks(a, z, a.diagonal()[i] + 1, a.rowStart()[i + 1]));
  }

 protected:
  void look(SystemMatrix& matrix) override { matrix_ = &matrix.assemble(); }
  bool make(SystemMatrix& matrix, SolveReport& report) override {
    look(matrix);
    inverse_.resize(matrix.rows());
    for (Index row = 0; row < matrix.rows(); ++row) {
      const Mat3 block = blockAt(matrix_->values(), matrix_->diagonal()[row]);
      if (!(Eigen::LLT<Mat3>(block).info() == Eigen::Success && block.allFinite())) return refuse(row, report);
      inverse_[row] = block.inverse();
    }
    return true;
  }

 private:
  /// The over-relaxation w.
  double omega_;
  /// The system's assembled matrix: not owned, read in every apply().
  const BlockMatrix* matrix_ = nullptr;
  std::vector<Mat3> inverse_;  ///< shape (rows), of the diagonal blocks
};

/// The same with D the numbers of the diagonal, and the upper triangle first: B^-1 = 1 / (w (2 - w)) (D + w L^T) D^-1 (D + w L).
class ScalarSsor final : public FollowingInverse {
 public:
  explicit ScalarSsor(double omega = 1) : omega_(omega) {}

  void apply(ConstRows r, Rows z) override {
    const BlockMatrix& a = *matrix_;
    for (Index i = a.rows() - 1; i >= 0; --i) {
      const RowBlock own = blockAt(a.values(), a.diagonal()[i]);
      const Vec3 later = sumOfBlocks(a, z, a.diagonal()[i] + 1, a.rowStart()[i + 1]);
      Vec3 now = Vec3::Zero();
      for (int c = 2; c >= 0; --c) now[c] = omega_ * (r[i][c] - later[c] - own.row(c).dot(now)) * inverse_[i][c];
      z[i] = now;
    }
    for (Index i = 0; i < a.rows(); ++i) {
      const RowBlock own = blockAt(a.values(), a.diagonal()[i]);
      const Vec3 former = sumOfBlocks(a, z, a.rowStart()[i], a.diagonal()[i]);
      Vec3 change = Vec3::Zero(), now = Vec3::Zero();
      for (int c = 0; c < 3; ++c) {
        change[c] = omega_ * (former[c] + own.row(c).dot(now)) * inverse_[i][c];
        now[c] = z[i][c] - change[c];
      }
      z[i] = now;
    }
    if (omega_ != 1)
      for (Index i = 0; i < a.rows(); ++i) z[i] *= 2 - omega_;
  }

 protected:
  void look(SystemMatrix& matrix) override { matrix_ = &matrix.assemble(); }
  bool make(SystemMatrix& matrix, SolveReport& report) override {
    look(matrix);
    inverse_.resize(matrix.rows());
    for (Index row = 0; row < matrix.rows(); ++row) {
      const Vec3 diagonal = blockAt(matrix_->values(), matrix_->diagonal()[row]).diagonal();
      if (!(diagonal.minCoeff() > 0 && diagonal.allFinite())) return refuse(row, report);
      inverse_[row] = diagonal.cwiseInverse();
    }
    return true;
  }

 private:
  double omega_;
  const BlockMatrix* matrix_ = nullptr;  ///< as in Ssor
  std::vector<Vec3> inverse_;            ///< shape (rows)
};

}  // namespace stroma
