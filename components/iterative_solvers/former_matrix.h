// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "framework/algebra/linear_solver.h"

namespace stroma {

/// A matrix as it was when somebody kept it, for a solver that factors it: the matrix itself may have other blocks by now, as
/// pairs in contact come and go. It shows one of several stored matrices at a time, which must outlive it; a pattern that is
/// shown again is the same one for whoever analysed it.
class FormerMatrix final : public SystemMatrix {
 public:
  void show(const BlockMatrix& stored, bool symmetric) {
    stored_ = &stored;
    symmetric_ = symmetric;
    ++key_values_;
    if (stored.columns() == columns_ && stored.rowStart() == row_start_) return;
    columns_ = stored.columns(), row_start_ = stored.rowStart();
    ++key_pattern_;
  }
  MatrixKey key() const override { return {identity().get(), key_pattern_, key_values_}; }
  Index rows() const override { return stored_ ? stored_->rows() : 0; }
  void multiply(ConstRows p, Rows out) const override { stored_->multiply(p, out); }
  const BlockMatrix& assemble() override { return *stored_; }
  void diagonalBlocks(std::vector<double>& blocks) const override {
    blocks.clear();
    for (const Index slot : stored_->diagonal()) {
      const auto first = stored_->values().begin() + std::ptrdiff_t(slot) * 9;
      blocks.insert(blocks.end(), first, first + 9);
    }
  }
  bool symmetric() const override { return symmetric_; }
  bool prefersAssembled(int) const override { return true; }
  std::string describeRow(Index row) const override { return "row " + std::to_string(row); }

 private:
  const BlockMatrix* stored_ = nullptr;
  bool symmetric_ = true;
  std::vector<Index> row_start_, columns_;  ///< of the pattern shown last
  long key_pattern_ = 0, key_values_ = 0;
};

}  // namespace stroma
