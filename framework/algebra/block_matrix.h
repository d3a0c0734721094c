// SPDX-License-Identifier: LGPL-2.1-or-later
// A sparse matrix of 3x3 blocks over the rows of a system, with a pattern fixed once and values filled often.
#pragma once
#include <memory>
#include <vector>

#include "framework/algebra/vector.h"

namespace stroma {

/// Collects which blocks can be non-zero.
class BlockPattern {
 public:
  explicit BlockPattern(Index rows) : columns_(std::size_t(rows)) {}
  Index rows() const { return Index(columns_.size()); }
  /// Every pair of the listed rows is coupled (both ways, and each with itself).
  void addClique(const Index* rows, int count);
  void addBlock(Index row, Index column);
  /// Of one row, in the order they were first added; long rows with repetitions.
  const std::vector<Index>& columns(Index row) const { return columns_[row]; }

 private:
  friend class BlockMatrix;
  /// Shape (rows); see columns().
  std::vector<std::vector<Index>> columns_;
};

/// Block compressed sparse rows; blocks are 9 doubles, row-major. All diagonal blocks are in the pattern.
class BlockMatrix {
 public:
  BlockMatrix() = default;
  /// Sorts and merges the pattern, which is used up; values are zero.
  explicit BlockMatrix(BlockPattern&& pattern);

  Index rows() const { return Index(row_start_.size()) - 1; }
  Index blocks() const { return row_start_.empty() ? 0 : row_start_.back(); }
  const std::vector<Index>& rowStart() const { return row_start_; }  ///< shape (rows + 1)
  const std::vector<Index>& columns() const { return columns_; }     ///< shape (blocks), ascending in a row
  const std::vector<Index>& diagonal() const { return diagonal_; }   ///< shape (rows): slot of the diagonal block
  std::vector<double>& values() { return values_; }                  ///< shape (blocks, 9)
  const std::vector<double>& values() const { return values_; }

  /// The slot of block (row, column); -1 when it is not in the pattern. Logarithmic in the row's length.
  Index slot(Index row, Index column) const;
  /// Values to zero; the pattern stays.
  void clear();
  /// Adds to the block at a slot, which must not be -1.
  void add(Index slot, const Mat3& block) {
    double* v = values_.data() + std::size_t(slot) * 9;
    // left to itself the compiler keeps the loops for the sake of the transposition, at twice the instructions
#pragma GCC unroll 3
    for (int r = 0; r < 3; ++r)
#pragma GCC unroll 3
      for (int c = 0; c < 3; ++c) v[3 * r + c] += block(r, c);
  }
  void add(Index row, Index column, const Mat3& block) { add(slot(row, column), block); }

  /// y = A x, with registers of four where the machine has them. 18 flops and 76 bytes per block.
  void multiply(ConstRows x, Rows y) const;
  /// Of a product with so many blocks, of which a symmetric one may read half [ns].
  static double productCost(double blocks, bool is_halved);
  /// Whether a matrix of so many blocks, made at the cost of `assembly`, is cheaper for so many products than products of `each`
  /// otherwise [ns]. A symmetric one is halved first, if it is new.
  static bool pays(double products, double each, double assembly, double blocks, bool is_halved);
  /// y += factor A x
  void multiplyAdd(double factor, ConstRows x, Rows y) const;
  static bool hasFours();  ///< whether products use AVX2 here

 private:
  std::vector<Index> row_start_{0}, columns_, diagonal_;
  std::vector<double> values_;
};

}  // namespace stroma
