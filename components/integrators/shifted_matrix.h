// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <exception>
#include <optional>
#include <vector>

#include <Eigen/Eigenvalues>

#include "components/integrators/matrix_view.h"

namespace stroma {

/// A + T + shift * D. T turns over what is unstable in rows whose block on the diagonal has eigenvalues below zero. First between nodes:
/// the part P of a block A_ij that has eigenvalues above zero, as of a spring in pressure, gets a spring of 2 P between i and j. It
/// resists no common movement, so that what is free keeps its momentum. Then what is below zero in the sum of the row, eigenvalues l with
/// vectors e, as of springs to what is held, gets sum 2 |l| e e^T, and so does what is left on the diagonal: all of it where there is no
/// matrix, but products alone. So a spring in pressure becomes one in tension, and rows that are stable, beside stable ones, stay as they
/// are. D is the mean size of the numbers on each row's diagonal; A is positive definite once the shift is large enough.
class ShiftedMatrix final : public MatrixView {
 public:
  /// `between`: also between nodes. What is solved for is then a result, else a direction, which all on the diagonal makes shorter.
  ShiftedMatrix(SystemMatrix& base, bool between) : MatrixView(base) {
    std::vector<double> blocks;
    base.diagonalBlocks(blocks);
    scale_.resize(std::size_t(base.rows()));
    for (std::size_t i = 0; i < scale_.size(); ++i) {
      // sizes, not their sum: the diagonal of an indefinite block can sum to nothing
      scale_[i] = (std::abs(blocks[9 * i]) + std::abs(blocks[9 * i + 4]) + std::abs(blocks[9 * i + 8])) / 3;
      const Mat3 block = evenPart(Eigen::Map<const Mat3>(blocks.data() + 9 * i));
      if (block.allFinite() && partOf(-block)) turned_.push_back({Index(i), block, Mat3::Zero()});
    }
    if (between && !turned_.empty()) turnBetween();
    for (Turned& each : turned_) each.block = each.ground + 2 * partOf(-each.block).value_or(Mat3::Zero());
  }
  /// Some block had something unstable.
  std::size_t turned() const { return turned_.size(); }
  void setShift(double shift) {
    if (shift > 0 && shift_ == 0) widenScale();
    shift_ = shift;
  }
  void multiply(ConstRows p, Rows out) const override {
    base_.multiply(p, out);
    for (const Turned& each : turned_) out[each.row] += each.block * p[each.row];
    for (const Between& each : between_) {
      const Vec3 f = each.block * (Vec3(p[each.a]) - Vec3(p[each.b]));
      out[each.a] += f, out[each.b] -= f;
    }
    if (shift_ == 0) return;
    for (Index i = 0; i < rows(); ++i) out[i] += shift_ * scale_[std::size_t(i)] * p[i];
  }
  const BlockMatrix& assemble() override {
    if (assembled_shift_ == shift_) return matrix_;
    assembled_shift_ = shift_;
    matrix_ = base_.assemble();
    for (const Turned& each : turned_) matrix_.add(matrix_.diagonal()[std::size_t(each.row)], each.block);
    for (const Between& each : between_) {
      for (const Index row : {each.a, each.b}) matrix_.add(matrix_.diagonal()[std::size_t(row)], each.block);
      matrix_.add(matrix_.slot(each.a, each.b), -each.block), matrix_.add(matrix_.slot(each.b, each.a), -each.block);
    }
    for (Index i = 0; i < rows() && shift_ > 0; ++i)
      matrix_.add(matrix_.diagonal()[std::size_t(i)], shift_ * scale_[std::size_t(i)] * Mat3::Identity());
    return matrix_;
  }
  void diagonalBlocks(std::vector<double>& blocks) const override {
    base_.diagonalBlocks(blocks);
    for (const Turned& each : turned_) Eigen::Map<Mat3>(blocks.data() + 9 * each.row) += each.block;
    for (const Between& each : between_)
      for (const Index row : {each.a, each.b}) Eigen::Map<Mat3>(blocks.data() + 9 * row) += each.block;
    for (std::size_t i = 0; i < scale_.size(); ++i)
      for (int c = 0; c < 3; ++c) blocks[9 * i + 4 * std::size_t(c)] += shift_ * scale_[i];
  }
  MatrixKey key() const override {
    MatrixKey key = base_.key();
    constexpr double any_shift = 1e6;
    key.shift = turned_.empty() ? shift_ : -1 - shift_ - (between_.empty() ? 0 : any_shift);  // another one than A without a shift, too
    return key;
  }

 private:
  struct Turned {
    Index row;
    Mat3 block, ground;
  };

  struct Between {
    Index a, b;
    Mat3 block;
  };

  static Mat3 evenPart(const Mat3& block) { return 0.5 * (block + block.transpose()); }
  /// Of a symmetric block: what has eigenvalues above zero; nothing where they are round-off.
  static std::optional<Mat3> partOf(const Mat3& block) {
    const Eigen::SelfAdjointEigenSolver<Mat3> found(block);
    if (!(found.eigenvalues()[2] > 1e-14 * block.cwiseAbs().maxCoeff())) return std::nullopt;  // they rise
    return Mat3(found.eigenvectors() * found.eigenvalues().cwiseMax(0).asDiagonal() * found.eigenvectors().transpose());
  }
  /// turned_ has the diagonal blocks of unstable rows, before and after. The sum of a row is what resists its movement with all others.
  void turnBetween() {
    const BlockMatrix* a = nullptr;
    try {
      a = &base_.assemble();
    } catch (const std::exception&) {
      return;  // products alone
    }
    std::vector<Turned*> of_row(std::size_t(rows()), nullptr);
    for (Turned& each : turned_) of_row[std::size_t(each.row)] = &each;
    for (Turned& each : turned_) {
      Mat3 sum = Mat3::Zero();
      for (Index slot = a->rowStart()[std::size_t(each.row)]; slot < a->rowStart()[std::size_t(each.row) + 1]; ++slot) {
        const Index other = a->columns()[std::size_t(slot)];
        const Mat3 block = evenPart(Eigen::Map<const Mat3>(a->values().data() + 9 * std::size_t(slot)));
        Turned* const also = of_row[std::size_t(other)];
        sum += block;
        if (other == each.row || (also && other < each.row)) continue;
        const std::optional<Mat3> part = block.allFinite() ? partOf(block) : std::nullopt;
        if (!part) continue;
        between_.push_back({each.row, other, 2 * *part});
        each.block += 2 * *part;
        if (also) also->block += 2 * *part;
      }
      if (sum.allFinite()) each.ground = 2 * partOf(-sum).value_or(Mat3::Zero());
    }
    for (Turned& each : turned_) each.block += each.ground;
  }
  /// A row whose own diagonal vanishes still needs a shift, of the size of what else is in it. That is seen by products with
  /// numbers of either sign, two because what is in a row may cancel in one. The mean of all rows is no measure: it would hold what
  /// is light.
  void widenScale() {
    Vector signs(rows()), product(rows());
    double mean = 0;
    for (const double value : scale_) mean += value / double(scale_.size());
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
  std::vector<Between> between_;
  double shift_ = 0, assembled_shift_ = -1;
  BlockMatrix matrix_;
};

}  // namespace stroma
