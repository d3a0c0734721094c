// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <Eigen/Eigenvalues>

#include "components/integrators/matrix_view.h"

namespace stroma {

/// A + T + shift * D. T turns over what is unstable in the blocks on the diagonal: a block with eigenvalues l and vectors e gets
/// sum 2 |l| e e^T of those below zero. So a spring in pressure becomes one in tension, and rows that are stable stay as they are.
/// D is the mean size of the numbers on each row's diagonal; A is positive definite once the shift is large enough.
class ShiftedMatrix final : public MatrixView {
 public:
  explicit ShiftedMatrix(SystemMatrix& base) : MatrixView(base) {
    std::vector<double> blocks;
    base.diagonalBlocks(blocks);
    scale_.resize(std::size_t(base.rows()));
    for (std::size_t i = 0; i < scale_.size(); ++i) {
      // sizes, not their sum: the diagonal of an indefinite block can sum to nothing
      scale_[i] = (std::abs(blocks[9 * i]) + std::abs(blocks[9 * i + 4]) + std::abs(blocks[9 * i + 8])) / 3;
      turnOver(Index(i), Mat3(Eigen::Map<const Mat3>(blocks.data() + 9 * i)));
    }
  }
  /// Some block had something unstable.
  std::size_t turned() const { return turned_.size(); }
  /// Rows far lighter than the mean, as those of turns of slender beams, are shifted by a part of it too: directions of Newton's method
  /// then do not run away along them. Where x is a result this would hold what is light.
  void holdLightRows() {
    const double mean = meanOfScale();
    for (double& value : scale_) value = std::max(value, 1e-3 * mean);
  }
  void setShift(double shift) {
    if (shift > 0 && shift_ == 0) widenScale();
    shift_ = shift;
  }
  void multiply(ConstRows p, Rows out) const override {
    base_.multiply(p, out);
    for (const Turned& each : turned_) out[each.row] += each.block * p[each.row];
    if (shift_ == 0) return;
    for (Index i = 0; i < rows(); ++i) out[i] += shift_ * scale_[std::size_t(i)] * p[i];
  }
  const BlockMatrix& assemble() override {
    if (assembled_shift_ == shift_) return matrix_;
    assembled_shift_ = shift_;
    matrix_ = base_.assemble();
    for (const Turned& each : turned_) matrix_.add(matrix_.diagonal()[std::size_t(each.row)], each.block);
    for (Index i = 0; i < rows() && shift_ > 0; ++i)
      matrix_.add(matrix_.diagonal()[std::size_t(i)], shift_ * scale_[std::size_t(i)] * Mat3::Identity());
    return matrix_;
  }
  void diagonalBlocks(std::vector<double>& blocks) const override {
    base_.diagonalBlocks(blocks);
    for (const Turned& each : turned_) Eigen::Map<Mat3>(blocks.data() + 9 * each.row) += each.block;
    for (std::size_t i = 0; i < scale_.size(); ++i)
      for (int c = 0; c < 3; ++c) blocks[9 * i + 4 * std::size_t(c)] += shift_ * scale_[i];
  }
  MatrixKey key() const override {
    MatrixKey key = base_.key();
    key.shift = turned_.empty() ? shift_ : -1 - shift_;  // another one than A without a shift, too
    return key;
  }

 private:
  struct Turned {
    Index row;
    Mat3 block;
  };

  void turnOver(Index row, const Mat3& block) {
    if (!block.allFinite()) return;
    const Mat3 even = 0.5 * (block + block.transpose());
    const Eigen::SelfAdjointEigenSolver<Mat3> found(even);
    const Vec3 below = found.eigenvalues().cwiseMin(0);
    if (!(below[0] < -1e-14 * even.cwiseAbs().maxCoeff())) return;  // eigenvalues rise; round-off is not unstable
    turned_.push_back({row, found.eigenvectors() * (-2 * below).asDiagonal() * found.eigenvectors().transpose()});
  }
  double meanOfScale() const {
    double mean = 0;
    for (const double value : scale_) mean += value / double(scale_.size());
    return mean;
  }
  /// A row whose own diagonal vanishes still needs a shift, of the size of what else is in it. That is seen by products with
  /// numbers of either sign, two because what is in a row may cancel in one. The mean of all rows is no measure: it would hold what
  /// is light.
  void widenScale() {
    Vector signs(rows()), product(rows());
    const double mean = meanOfScale();
    std::vector<double> sizes(scale_.size());
    std::uint32_t state = 1;
    for (int probe = 0; probe < 2; ++probe) {
      for (Index i = 0; i < rows(); ++i)
        for (int c = 0; c < 3; ++c) signs[i][c] = (state = 1664525 * state + 1013904223) >> 31 ? 1 : -1;
      base_.multiply(signs, product);
      for (Index i = 0; i < rows(); ++i) sizes[std::size_t(i)] = std::max(sizes[std::size_t(i)], product[i].cwiseAbs().maxCoeff());
    }
    for (std::size_t i = 0; i < scale_.size(); ++i) scale_[i] = std::max(scale_[i], 1e-3 * (sizes[i] > 0 ? sizes[i] : mean));
  }

  std::vector<double> scale_;  ///< shape (rows)
  std::vector<Turned> turned_;
  double shift_ = 0, assembled_shift_ = -1;
  BlockMatrix matrix_;
};

}  // namespace stroma
