// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "components/integrators/matrix_view.h"

namespace stroma {

/// A + shift * D, D the mean size of the numbers on each row's diagonal: positive definite once the shift is large
/// enough.
class ShiftedMatrix final : public MatrixView {
 public:
  explicit ShiftedMatrix(SystemMatrix& base) : MatrixView(base) {
    std::vector<double> blocks;
    base.diagonalBlocks(blocks);
    scale_.resize(base.rows());
    double mean = 0;
    for (std::size_t i = 0; i < scale_.size(); ++i) {
      // sizes, not their sum: the diagonal of an indefinite block can sum to nothing
      scale_[i] = (std::abs(blocks[9 * i]) + std::abs(blocks[9 * i + 4]) + std::abs(blocks[9 * i + 8])) / 3;
      mean += scale_[i] / double(scale_.size());
    }
    // a row whose own diagonal vanishes still needs a shift
    for (double& value : scale_) value = std::max(value, 1e-3 * mean);
  }
  void setShift(double shift) { shift_ = shift; }
  void multiply(ConstRows p, Rows out) const override {
    base_.multiply(p, out);
    for (Index i = 0; i < rows(); ++i) out[i] += shift_ * scale_[i] * p[i];
  }
  const BlockMatrix& assemble() override {
    if (assembled_shift_ == shift_) return matrix_;
    assembled_shift_ = shift_;
    matrix_ = base_.assemble();
    for (Index i = 0; i < rows(); ++i) matrix_.add(matrix_.diagonal()[i], shift_ * scale_[i] * Mat3::Identity());
    return matrix_;
  }
  void diagonalBlocks(std::vector<double>& blocks) const override {
    base_.diagonalBlocks(blocks);
    for (std::size_t i = 0; i < scale_.size(); ++i)
      for (int c = 0; c < 3; ++c) blocks[9 * i + 4 * std::size_t(c)] += shift_ * scale_[i];
  }
  MatrixKey key() const override {
    MatrixKey key = base_.key();
    key.shift = shift_;
    return key;
  }

 private:
  std::vector<double> scale_;  ///< shape (rows)
  double shift_ = 0, assembled_shift_ = 0;
  BlockMatrix matrix_;
};

}  // namespace stroma
