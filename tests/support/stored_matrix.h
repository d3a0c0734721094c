// SPDX-License-Identifier: LGPL-2.1-or-later
// A SystemMatrix that is a stored block matrix, for tests of linear solvers; and random ones.
#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <limits>
#include <memory>
#include <random>

#include "framework/algebra/linear_solver.h"
#include "framework/algebra/volume_terms.h"

namespace stroma::test {

class StoredMatrix final : public SystemMatrix, public HasVolumeTerms {
 public:
  explicit StoredMatrix(BlockMatrix matrix) : values(std::move(matrix)) {}
  BlockMatrix values;
  long revision_number = 1, pattern_number = 1;
  bool is_symmetric = true, prefers_assembled = false, has_turns = false;
  int assembled_from = std::numeric_limits<int>::max();  ///< products, and else where it prefers that
  double product_nanoseconds = 0;    ///< 0: not known
  double assembly_nanoseconds = -1;  ///< below 0: not known
  mutable int products = 0, assemblies = 0;

  Index rows() const override { return values.rows(); }
  void multiply(ConstRows p, Rows out) const override {
    ++products;
    values.multiply(p, out);
  }
  const BlockMatrix& assemble() override {
    ++assemblies;
    return values;
  }
  void diagonalBlocks(std::vector<double>& blocks) const override {
    blocks.resize(std::size_t(rows()) * 9);
    for (Index i = 0; i < rows(); ++i)
      std::copy_n(values.values().begin() + std::ptrdiff_t(values.diagonal()[i]) * 9, 9,
                  blocks.begin() + std::ptrdiff_t(i) * 9);
  }
  MatrixKey key() const override { return {identity().get(), pattern_number, revision_number}; }
  bool symmetric() const override { return is_symmetric; }
  bool hasTurns() const override { return has_turns; }
  bool prefersAssembled(int count) const override { return prefers_assembled || count >= assembled_from; }
  double productCost() const override { return product_nanoseconds; }
  double assemblyCost() const override { return assembly_nanoseconds; }
  VolumeTerms volumes;  ///< that it has, or none
  VolumeTerms volumeTerms() const override { return volumes; }
  std::vector<Vec3> nodes;  ///< where the rows are, or empty
  ConstRows positions() const override {
    if (nodes.empty()) return {};
    if (placed_.count() != rows()) placed_.resize(rows());
    double* at = placed_.rows().data;
    for (const Vec3& node : nodes) std::copy_n(node.data(), 3, at), at += row_doubles;
    return placed_;
  }
  std::string describeRow(Index row) const override { return "row " + std::to_string(row); }

  Eigen::MatrixXd dense() const {
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(3 * rows(), 3 * rows());
    for (Index i = 0; i < rows(); ++i)
      for (Index s = values.rowStart()[i]; s < values.rowStart()[i + 1]; ++s)
        for (int k = 0; k < 9; ++k)
          a(3 * i + k / 3, 3 * values.columns()[s] + k % 3) = values.values()[std::size_t(9 * s + k)];
    return a;
  }

 private:
  mutable Vector placed_;
};

/// Each node is coupled to `neighbours` random others by B^T B with B random 3x6, and to the ground by `ground`:
/// symmetric and positive definite.
inline StoredMatrix randomMatrix(Index rows, int neighbours, double ground, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_int_distribution<Index> node(0, rows - 1);
  std::uniform_real_distribution<double> number(-1, 1);
  std::vector<std::array<Index, 2>> pairs;
  BlockPattern pattern(rows);
  for (Index i = 0; i < rows; ++i)
    for (int n = 0; n < neighbours; ++n) {
      const std::array<Index, 2> pair{i, node(generator)};
      if (pair[0] == pair[1]) continue;
      pairs.push_back(pair);
      pattern.addClique(pair.data(), 2);
    }
  BlockMatrix matrix(std::move(pattern));
  for (const auto& pair : pairs) {
    Eigen::Matrix<double, 3, 6> b;
    for (int k = 0; k < 18; ++k) b.data()[k] = number(generator);
    const Eigen::Matrix<double, 6, 6> k = b.transpose() * b;
    for (int p = 0; p < 2; ++p)
      for (int q = 0; q < 2; ++q) matrix.add(pair[p], pair[q], Mat3(k.block<3, 3>(3 * p, 3 * q)));
  }
  for (Index i = 0; i < rows; ++i) matrix.add(i, i, ground * Mat3::Identity());
  return StoredMatrix(std::move(matrix));
}

inline Vector randomVector(Index rows, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> number;
  Vector vector(rows);
  for (Index i = 0; i < rows; ++i)
    for (int c = 0; c < 3; ++c) vector[i][c] = number(generator);
  return vector;
}

inline Eigen::VectorXd dense(ConstRows rows) {
  Eigen::VectorXd vector(3 * rows.count);
  for (Index i = 0; i < rows.count; ++i) vector.segment<3>(3 * i) = rows[i];
  return vector;
}

}  // namespace stroma::test
