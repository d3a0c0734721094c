// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include <Eigen/Eigenvalues>

#include "components/integrators/matrix_view.h"
#include "framework/simulation/system.h"

namespace stroma {

/// A + T + shift * D. T reflects unstable directions: compressed springs become springs in tension. D is the mean absolute diagonal
/// entry of each row; the matrix is positive definite once the shift is large enough. A search direction needs no T.
///
/// Between points i and j, with P the positive part of the symmetric part of A_ij, T_ii and T_jj get 2 P, and T_ij and T_ji -2 P. T does
/// not affect common translations, so a free body gets the whole impulse of the forces on it. The row sum of A connects a node to the
/// ground and to fixed ends. Its negative part, and any remaining negative part of a diagonal block, are reflected
/// there: eigenvalues l with vectors e add sum 2 |l| e e^T.
class ShiftedMatrix final : public MatrixView {
 public:
  /// The rows whose pairs are used: none, so T is zero; those whose diagonal block has a negative eigenvalue; those whose block has one
  /// after subtraction of all P of the row.
  enum class Turns { none, unstable_blocks, unstable_rows };

  /// `system`: owns the rows; needed for T. Rows that are not points, and nodes tied by constraints, have no pairs.
  ShiftedMatrix(SystemMatrix& base, Turns turns, const System* system = nullptr) : MatrixView(base), turns_(turns) {
    base.diagonalBlocks(blocks_);
    scale_.resize(std::size_t(base.rows()));
    for (std::size_t i = 0; i < scale_.size(); ++i)
      // absolute values: the diagonal of an indefinite block can sum to zero
      scale_[i] = (std::abs(blocks_[9 * i]) + std::abs(blocks_[9 * i + 4]) + std::abs(blocks_[9 * i + 8])) / 3;
    if (turns == Turns::none) return;
    is_turned_.resize(scale_.size());
    const ConstraintSet& constraints = system->constraints();
    if (constraints.groups().empty() && constraints.relations().empty()) turnPairs(base.assemble(), *system);
    for (Index i = 0; i < rows(); ++i) turnOver(i, partAbove(-block(i)));
  }
  /// Rows with unstable directions.
  std::size_t turned() const { return std::size_t(std::count(is_turned_.begin(), is_turned_.end(), true)); }
  const std::vector<double>& scale() const { return scale_; }  ///< D, shape (rows)
  void setShift(double shift) {
    if (shift > 0 && shift_ == 0) widenScale();
    shift_ = shift;
  }
  void multiply(ConstRows p, Rows out) const override {
    base_.multiply(p, out);
    for (const Turned& each : turned_) out[each.row] += each.block * p[each.row];
    for (const Pair& each : pairs_) {
      out[each.i] += each.ii * p[each.i] + each.ij * p[each.j];
      out[each.j] += each.ij.transpose() * p[each.i] + each.jj * p[each.j];
    }
    if (shift_ == 0) return;
    for (Index i = 0; i < rows(); ++i) out[i] += shift_ * scale_[std::size_t(i)] * p[i];
  }
  const BlockMatrix& assemble() override {
    if (assembled_shift_ == shift_) return matrix_;
    assembled_shift_ = shift_;
    matrix_ = base_.assemble();
    for (const Turned& each : turned_) matrix_.add(matrix_.diagonal()[std::size_t(each.row)], each.block);
    for (const Pair& each : pairs_) {
      matrix_.add(each.i, each.i, each.ii), matrix_.add(each.j, each.j, each.jj);
      matrix_.add(each.i, each.j, each.ij), matrix_.add(each.j, each.i, each.ij.transpose());
    }
    for (Index i = 0; i < rows() && shift_ > 0; ++i)
      matrix_.add(matrix_.diagonal()[std::size_t(i)], shift_ * scale_[std::size_t(i)] * Mat3::Identity());
    return matrix_;
  }
  void diagonalBlocks(std::vector<double>& blocks) const override {
    base_.diagonalBlocks(blocks);
    for (const Turned& each : turned_) Eigen::Map<Mat3>(blocks.data() + 9 * each.row) += each.block;
    for (const Pair& each : pairs_) {
      Eigen::Map<Mat3>(blocks.data() + 9 * each.i) += each.ii;
      Eigen::Map<Mat3>(blocks.data() + 9 * each.j) += each.jj;
    }
    for (std::size_t i = 0; i < scale_.size(); ++i)
      for (int c = 0; c < 3; ++c) blocks[9 * i + 4 * std::size_t(c)] += shift_ * scale_[i];
  }
  MatrixKey key() const override {
    MatrixKey key = base_.key();
    // must differ from A without a shift, and for each T
    key.shift = turned() == 0 ? shift_ : -1 - shift_ - (turns_ == Turns::unstable_rows ? 1e6 : 0);
    return key;
  }

 private:
  struct Turned {
    Index row;
    Mat3 block;
  };
  struct Pair {
    Index i, j;
    Mat3 ii, jj, ij;  ///< with Q onto the free directions of each row: Q_i 2P Q_i, Q_j 2P Q_j, -Q_i 2P Q_j
  };

  Mat3 block(Index row) const { return Eigen::Map<const Mat3>(blocks_.data() + 9 * row); }
  /// The positive part of the symmetric part; round-off is dropped.
  static Mat3 partAbove(const Mat3& block, double size = 0) {
    if (!block.allFinite() || block.isZero(0)) return Mat3::Zero();
    const Mat3 even = 0.5 * (block + block.transpose());
    const Eigen::SelfAdjointEigenSolver<Mat3> found(even);
    const double round_off = 1e-14 * std::max(size, even.cwiseAbs().maxCoeff());
    const Vec3 above = (found.eigenvalues().array() > round_off).select(found.eigenvalues(), 0);
    return found.eigenvectors() * above.asDiagonal() * found.eigenvectors().transpose();
  }
  void turnOver(Index row, const Mat3& below) {
    if (below.isZero(0)) return;
    turned_.push_back({row, 2 * below});
    Eigen::Map<Mat3>(blocks_.data() + 9 * row) += 2 * below;
    is_turned_[std::size_t(row)] = true;
  }
  struct Above {
    Index i, j;  ///< i < j
    Mat3 part;   ///< P
  };
  /// `sums`: row sums; on entry the diagonal blocks.
  static std::vector<Above> partsAbove(const BlockMatrix& matrix, const Motion& motion, std::vector<Mat3>& sums) {
    std::vector<Above> found;
    const auto at = [&](Index slot) { return Mat3(Eigen::Map<const Mat3>(matrix.values().data() + 9 * std::size_t(slot))); };
    for (Index i = 0; i < matrix.rows(); ++i)
      for (Index slot = matrix.diagonal()[std::size_t(i)] + 1; slot < matrix.rowStart()[std::size_t(i) + 1]; ++slot) {
        const Index j = matrix.columns()[std::size_t(slot)], other = matrix.slot(j, i);
        if (other < 0 || motion.kindOf(i) != RowKind::place || motion.kindOf(j) != RowKind::place) continue;
        sums[std::size_t(i)] += at(slot), sums[std::size_t(j)] += at(other);
        if (const Mat3 above = partAbove(0.5 * (at(slot) + at(other))); !above.isZero(0)) found.push_back({i, j, above});
      }
    return found;
  }
  void turnPairs(const BlockMatrix& matrix, const System& system) {
    std::vector<Mat3> left(scale_.size()), free(scale_.size(), Mat3::Identity());
    for (Index i = 0; i < rows(); ++i) left[std::size_t(i)] = block(i);
    for (const NodeProjector& held : system.constraints().projectors()) free[std::size_t(held.row)] = held.projector;
    std::vector<Mat3> sums = left;
    const std::vector<Above> all = partsAbove(matrix, system.motion(), sums);
    for (const Above& each : all)
      if (turns_ == Turns::unstable_rows) left[std::size_t(each.i)] -= each.part, left[std::size_t(each.j)] -= each.part;
    std::vector<bool> is_unstable(scale_.size());
    for (std::size_t i = 0; i < left.size(); ++i) is_unstable[i] = !partAbove(-left[i]).isZero(0);
    for (const Above& each : all) {
      const std::size_t i = std::size_t(each.i), j = std::size_t(each.j);
      if (!is_unstable[i] && !is_unstable[j]) continue;
      const Mat3 twice = 2 * each.part;
      pairs_.push_back({each.i, each.j, free[i] * twice * free[i], free[j] * twice * free[j], -free[i] * twice * free[j]});
      Eigen::Map<Mat3>(blocks_.data() + 9 * i) += pairs_.back().ii;
      Eigen::Map<Mat3>(blocks_.data() + 9 * j) += pairs_.back().jj;
      is_turned_[i] = is_turned_[j] = true;
    }
    for (std::size_t i = 0; i < sums.size(); ++i)
      if (is_unstable[i]) turnOver(Index(i), partAbove(-(free[i] * sums[i] * free[i]), 100 * left[i].cwiseAbs().maxCoeff()));
  }
  /// A row with a small or zero diagonal, like the rotations of a thin beam, also needs a shift: 1e-3 of the mean over its connected
  /// rows. The mean over all rows would hold back a light falling body beside a heavy one.
  void widenScale() {
    const BlockMatrix& ties = base_.pattern();
    std::vector<Index> body(scale_.size(), -1), todo;
    std::vector<double> least;  // per body
    for (Index first = 0; first < rows(); ++first) {
      if (body[std::size_t(first)] >= 0) continue;
      double sum = 0;
      std::size_t count = 0;
      body[std::size_t(first)] = Index(least.size()), todo = {first};
      while (count < todo.size()) {
        const std::size_t row = std::size_t(todo[count++]);
        sum += scale_[row];
        for (Index slot = ties.rowStart()[row]; slot < ties.rowStart()[row + 1]; ++slot)
          if (Index& other = body[std::size_t(ties.columns()[std::size_t(slot)])]; other < 0)
            other = Index(least.size()), todo.push_back(ties.columns()[std::size_t(slot)]);
      }
      least.push_back(1e-3 * sum / double(count));
    }
    const double some = 1e-3 * std::accumulate(scale_.begin(), scale_.end(), 0.0) / double(scale_.size());
    for (std::size_t i = 0; i < scale_.size(); ++i) {
      const double of_body = least[std::size_t(body[i])];
      scale_[i] = std::max(scale_[i], of_body > 0 ? of_body : some);
    }
  }

  std::vector<double> scale_;  ///< shape (rows)
  Turns turns_;
  std::vector<double> blocks_;  ///< shape (rows, 9): the diagonal, and what pairs add to it
  std::vector<Pair> pairs_;
  std::vector<Turned> turned_;
  std::vector<bool> is_turned_;  ///< shape (rows)
  double shift_ = 0, assembled_shift_ = -1;
  BlockMatrix matrix_;
};

}  // namespace stroma
