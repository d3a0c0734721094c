// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "framework/algebra/linear_solver.h"
#include "framework/algebra/memory.h"

namespace stroma {

/// A symmetric matrix of blocks for products. Of two blocks that mirror each other one is kept and read once for both rows. Rows
/// are cut into pieces, which threads share: a block that leads out of its piece is kept in both rows, so that a piece writes
/// to its own rows alone, and results are the same for any number of threads.
class SymmetricBlocks {
 public:
  /// Takes the matrix, which has this key. False: its pattern is not that of a symmetric one, and nothing is kept.
  bool follow(const BlockMatrix& matrix, const MatrixKey& key);
  /// y = A x, with registers of four where the machine has them. 30 flops and 76 bytes for a block that is kept.
  void multiply(ConstRows x, Rows y) const;
  Index blocks() const { return Index(columns_.size()); }  ///< that are kept

  /// Of a matrix of so many rows. A piece is at least some ten thousand tetrahedra.
  static int piecesOf(Index rows);

 private:
  bool takePattern(const BlockMatrix& matrix);
  void takeValues(const BlockMatrix& matrix);

  MatrixKey key_;
  bool is_symmetric_ = false;   ///< the pattern
  std::vector<Index> first_;    ///< rows of the pieces, shape (pieces + 1)
  std::vector<Index> start_;    ///< of a row's blocks, shape (rows + 1)
  std::vector<Index> alone_;    ///< the diagonal block, behind those that the mirrored row reads too, shape (rows)
  std::vector<Index> columns_;  ///< shape (blocks)
  std::vector<Index> slots_;    ///< in the matrix, shape (blocks)
  /// In an order in which no load straddles a cache line: 0 1 2 6, 3 4 5 7, and the last number of a block in an array of its own.
  Array<double> numbers_, last_;  ///< shape (blocks, 8), (blocks)
};

}  // namespace stroma
