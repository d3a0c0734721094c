// SPDX-License-Identifier: LGPL-2.1-or-later
// The nearest negative semi-definite matrix against Eigen's eigenvalues: random, repeated, zero, huge and tiny ones, on
// doubles and on packs.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <random>

#include "components/hyperelasticity/symmetric_projection.h"

namespace stroma {
namespace STROMA_TEST_FILE {

constexpr int n = 9;
using Matrix = Eigen::Matrix<double, n, n>;

/// Q diag(values) Q^T with a random orthogonal Q.
Matrix withEigenvalues(const Eigen::Vector<double, n>& values, std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  Matrix any;
  for (int i = 0; i < n * n; ++i) any(i / n, i % n) = uniform(random);
  const Matrix q = any.householderQr().householderQ();
  const Matrix m = q * values.asDiagonal() * q.transpose();
  return (m + m.transpose()) / 2;
}
std::vector<Matrix> cases() {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Matrix> all{Matrix::Zero(), Matrix::Identity(), -Matrix::Identity()};
  Matrix pairs = Matrix::Zero();  // a diagonal of zeros
  pairs(0, 1) = pairs(1, 0) = 2, pairs(4, 7) = pairs(7, 4) = -3;
  all.push_back(pairs);
  for (double scale : {1., 1e-9, 1e9, 1e-100, 1e100})
    for (int k = 0; k < 6; ++k) {
      Eigen::Vector<double, n> values;
      for (int i = 0; i < n; ++i) values[i] = scale * uniform(random);
      all.push_back(withEigenvalues(values, random));
    }
  for (double low : {-1., 1e-12}) {
    Eigen::Vector<double, n> repeated;
    repeated << 5, 5, 5, 5, low, low, low, 0, 0;
    all.push_back(withEigenvalues(repeated, random));
  }
  Eigen::Vector<double, n> spread;
  spread << 1e8, -1e8, 1e4, -1e4, 1, -1, 1e-4, -1e-4, 0;
  all.push_back(withEigenvalues(spread, random));
  return all;
}
Matrix expected(const Matrix& m) {
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(m);
  return solver.eigenvectors() * solver.eigenvalues().cwiseMin(0).asDiagonal() * solver.eigenvectors().transpose();
}
template <class T>
Matrix projected(const Matrix& m, int lane) {
  T a[n][n];
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) a[i][j] = T(m(i, j));
  projectNegative(a);
  Matrix out;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      if constexpr (std::is_same_v<T, double>)
        out(i, j) = a[i][j];
      else
        out(i, j) = a[i][j].get(std::size_t(lane));
  return out;
}
void expectNear(const Matrix& result, const Matrix& m) {
  const double scale = m.cwiseAbs().maxCoeff();
  EXPECT_LE((result - expected(m)).cwiseAbs().maxCoeff(), 1e-13 * scale) << m;
  EXPECT_TRUE(result == result.transpose());
  const Matrix sized = scale > 0 ? Matrix(result / scale) : result;
  EXPECT_LE(Eigen::SelfAdjointEigenSolver<Matrix>(sized).eigenvalues().maxCoeff(), 1e-14);
}

TEST(SymmetricProjection, IsTheNearestNegativeMatrix) {
  for (const Matrix& m : cases()) {
    expectNear(projected<double>(m, 0), m);
    expectNear(projected<Pack>(m, pack_lanes - 1), m);
  }
}

/// Every lane its own matrix: those that are done early are not spoilt by the others.
TEST(SymmetricProjection, LanesDoNotMeet) {
  const std::vector<Matrix> all = cases();
  Pack a[n][n];
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      double lanes[pack_lanes];
      for (int l = 0; l < pack_lanes; ++l) lanes[l] = all[l](i, j);
      a[i][j] = Pack::load_unaligned(lanes);
    }
  projectNegative(a);
  for (int l = 0; l < pack_lanes; ++l) {
    Matrix out;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) out(i, j) = a[i][j].get(std::size_t(l));
    expectNear(out, all[l]);
  }
}

TEST(SymmetricProjection, NaNStays) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const auto& [row, column] : {std::pair{2, 2}, std::pair{5, 1}}) {
    Matrix m = -Matrix::Identity();
    m(row, column) = m(column, row) = nan;
    const Matrix result = projected<double>(m, 0);
    EXPECT_TRUE(std::isnan(result(row, column))) << row << " " << column;
    EXPECT_TRUE(std::isnan(projected<Pack>(m, 0)(row, column))) << row << " " << column;
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma
