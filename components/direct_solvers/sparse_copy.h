// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <Eigen/SparseCore>

#include "framework/algebra/block_matrix.h"

namespace stroma {

/// A block matrix as compressed columns of numbers, shape (3 rows, 3 rows); the pattern is made once.
class SparseCopy {
 public:
  using Matrix = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;
  /// Compressed columns of numbers; owned.
  Matrix matrix;

  /// Makes the pattern of `from`, with explicit zeros inside blocks. Allocates.
  void layOut(const BlockMatrix& from) {
    const Index count = 3 * from.rows();
    std::vector<Eigen::Triplet<double, int>> entries;
    entries.reserve(from.values().size());
    for (Index i = 0; i < from.rows(); ++i)
      for (Index s = from.rowStart()[i]; s < from.rowStart()[i + 1]; ++s)
        for (int k = 0; k < 9; ++k)
          entries.emplace_back(3 * i + k / 3, 3 * from.columns()[s] + k % 3, double(9 * s + k));
    matrix.resize(count, count);
    matrix.setFromTriplets(entries.begin(), entries.end());
    // the values above are positions: where each entry of the compressed columns comes from
    source_.assign(matrix.valuePtr(), matrix.valuePtr() + matrix.nonZeros());
  }
  /// Copies the values of a matrix of that pattern. Does not allocate.
  void fill(const BlockMatrix& from) {
    for (std::size_t i = 0; i < source_.size(); ++i) matrix.valuePtr()[i] = from.values()[source_[i]];
  }

 private:
  /// Where each number of `matrix` lies in the values of the block matrix, shape (non-zeros).
  std::vector<double> source_;
};

/// Rows to three numbers per row, and back (scatter).
inline void gather(ConstRows from, Eigen::VectorXd& out) {
  out.resize(3 * from.count);
  for (Index i = 0; i < from.count; ++i) out.segment<3>(3 * i) = from[i];
}
inline void scatter(const Eigen::VectorXd& from, Rows out) {
  for (Index i = 0; i < out.count; ++i) out[i] = from.segment<3>(3 * i);
}

}  // namespace stroma
