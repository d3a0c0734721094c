// SPDX-License-Identifier: LGPL-2.1-or-later
// Incomplete Cholesky factors without fill, by 3x3 blocks. Inline for the reason given in vector.h.
#pragma once
#include "components/iterative_solvers/sweeps.h"

namespace stroma {

/// A ~ L L^T, L with the pattern of the lower triangle of A (Meijerink and van der Vorst 1977). Where a pivot block is
/// not positive definite although A is, A + shift * (block diagonal of A) is factored instead (Manteuffel 1980), shift
/// growing from 1e-3 by factors of 4 until it works; by 1 at the latest the matrix is dominated by its diagonal.
class IncompleteCholesky final : public FollowingInverse {
 public:
  double shift() const override { return shift_; }

  void apply(ConstRows r, Rows z) override {
    const Index rows = Index(start_.size()) - 1;
    for (Index i = 0; i < rows; ++i) {
      Vec3 sum = r[i];
      for (Index s = start_[i]; s < start_[i + 1]; ++s) sum -= blockAt(lower_, s) * z[columns_[s]];
      z[i] = pivot_[i] * sum;
    }
    for (Index i = rows - 1; i >= 0; --i) {
      const Vec3 value = pivot_[i].transpose() * z[i];
      z[i] = value;
      for (Index s = start_[i]; s < start_[i + 1]; ++s) z[columns_[s]] -= blockAt(lower_, s).transpose() * value;
    }
  }

 protected:
  bool make(SystemMatrix& matrix, SolveReport& report) override {
    const BlockMatrix& a = matrix.assemble();
    layOut(a);
    for (Index i = 0; i < a.rows(); ++i) {
      const RowBlock block = blockAt(a.values(), a.diagonal()[i]);
      if (!block.allFinite() || Eigen::LLT<RowBlock>(block).info() != Eigen::Success) return refuse(i, report);
    }
    Index bad = 0;
    for (shift_ = 0; shift_ < 5; shift_ = shift_ == 0 ? 1e-3 : 4 * shift_) {
      bad = factor(a);
      if (bad < 0) return true;
    }
    return refuse(bad, report);
  }

 private:
  /// The strict lower triangle of the pattern of A, by rows.
  void layOut(const BlockMatrix& a) {
    const std::size_t rows = std::size_t(a.rows());
    start_.resize(rows + 1);
    columns_.clear();
    for (std::size_t i = 0; i < rows; ++i) {
      start_[i] = Index(columns_.size());
      for (Index s = a.rowStart()[i]; s < a.diagonal()[i]; ++s) columns_.push_back(a.columns()[s]);
    }
    start_[rows] = Index(columns_.size());
    lower_.resize(columns_.size() * 9);
    pivot_.resize(rows);
  }

  /// Row by row: L_ij = (A_ij - sum_k L_ik L_jk^T) L_jj^-T. Returns the first row without a pivot, or -1.
  Index factor(const BlockMatrix& a) {
    for (Index i = 0; i < a.rows(); ++i) {
      const Index first = start_[i], last = start_[i + 1];
      RowBlock diagonal = (1 + shift_) * blockAt(a.values(), a.diagonal()[i]);
      for (Index s = first; s < last; ++s) {
        const Index j = columns_[s];
        RowBlock sum = blockAt(a.values(), a.rowStart()[i] + s - first);
        Index p = first, q = start_[j];
        const Index q_last = start_[j + 1];
        while (p < s && q < q_last) {
          const Index left = columns_[p], right = columns_[q];
          if (left == right) sum.noalias() -= blockAt(lower_, p) * blockAt(lower_, q).transpose();
          p += left <= right, q += right <= left;
        }
        const RowBlock block = sum * pivot_[j].transpose();
        blockAt(lower_, s) = block;
        diagonal.noalias() -= block * block.transpose();
      }
      // a pivot that is all round-off is as good as none
      const double enough = 1e-12 * blockAt(a.values(), a.diagonal()[i]).trace();
      const Eigen::LLT<RowBlock> llt(diagonal);
      if (llt.info() != Eigen::Success) return i;
      const RowBlock l = llt.matrixL();
      if (!(l.diagonal().array().square().minCoeff() > enough)) return i;
      pivot_[i] = l.triangularView<Eigen::Lower>().solve(RowBlock::Identity().eval());
    }
    return -1;
  }

  std::vector<Index> start_, columns_;  ///< of the strictly lower triangle, shapes (rows + 1), (blocks)
  std::vector<double> lower_;           ///< L off the diagonal, shape (blocks, 9)
  std::vector<RowBlock> pivot_;         ///< shape (rows): L_ii^-1
  double shift_ = 0;
};

}  // namespace stroma
