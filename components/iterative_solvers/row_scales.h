// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cmath>
#include <vector>

#include "framework/algebra/linear_solver.h"

namespace stroma {

/// One number s for each row of a matrix of which some rows turn, s = |tr D / 3|^-1/2 with D its diagonal block. |S r| then measures
/// forces and torques alike, as r.D^-1 r of conjugate gradients does, and S A S is symmetric where A is. Without rows that turn
/// there are none, and r is measured as it is, unless they are wanted: for bodies far lighter than others.
class RowScales {
 public:
  void take(const SystemMatrix& matrix, bool are_wanted = false) {
    scales_.clear();
    if (!matrix.hasTurns() && !are_wanted) return;
    matrix.diagonalBlocks(blocks_);
    for (std::size_t at = 0; at < blocks_.size(); at += 9) {
      const double size = 1 / std::sqrt(std::abs(blocks_[at] + blocks_[at + 4] + blocks_[at + 8]) / 3);
      scales_.push_back(std::isfinite(size) && size > 0 ? size : 1);
    }
  }
  bool empty() const { return scales_.empty(); }
  /// rows = S rows
  void multiply(Rows rows) const {
    for (std::size_t i = 0; i < scales_.size(); ++i) rows[Index(i)] *= scales_[i];
  }
  /// rows = S^-1 rows; returns them.
  Rows divide(Rows rows) const {
    for (std::size_t i = 0; i < scales_.size(); ++i) rows[Index(i)] /= scales_[i];
    return rows;
  }

 private:
  std::vector<double> scales_;  ///< shape (rows), or empty
  std::vector<double> blocks_;  ///< work space
};

}  // namespace stroma
