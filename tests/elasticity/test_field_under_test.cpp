// SPDX-License-Identifier: LGPL-2.1-or-later
// What the checks of force fields measure with: on vectors and shapes whose answer is known.
#include "tests/support/field_under_test.h"

#include <gtest/gtest-spi.h>

namespace stroma::test {
namespace {

Vector rowsOf(const std::vector<Vec3>& values) {
  Vector rows(Index(values.size()));
  for (Index i = 0; i < rows.count(); ++i) rows[i] = values[std::size_t(i)];
  return rows;
}

TEST(FieldUnderTest, MeasuresDifferencesAndMomenta) {
  const Vec3 zero = Vec3::Zero();
  EXPECT_DOUBLE_EQ(relativeDifference(rowsOf({{3, 0, 0}, zero}), rowsOf({zero, {0, 4, 0}})), 1.25);
  EXPECT_EQ(relativeDifference(rowsOf({zero}), rowsOf({zero})), 0);
  const Vector ends = rowsOf({{6, 5, 5}, {4, 5, 5}});
  const Momentum couple = momentumOf(ends, rowsOf({{0, 2, 0}, {0, -2, 0}})),
                 push = momentumOf(ends, rowsOf({{0, 2, 0}, {0, 2, 0}}));
  EXPECT_DOUBLE_EQ(couple.force, 0);
  EXPECT_DOUBLE_EQ(couple.torque, 1);
  EXPECT_DOUBLE_EQ(push.force, 1);
  EXPECT_DOUBLE_EQ(push.torque, 0);
}

TEST(FieldUnderTest, ADiagonalThatDiffersIsSaid) {
  BlockMatrix matrix{BlockPattern(2)};
  std::vector<double> diagonal(18);
  for (Index row = 0; row < 2; ++row) {
    const Mat3 block = Vec3(1, 2, 3 + row).asDiagonal();
    matrix.add(row, row, block);
    for (int i = 0; i < 9; ++i) diagonal[std::size_t(9 * row + i)] = block(i / 3, i % 3);
  }
  expectDiagonalOf(matrix, diagonal);
  for (double& number : diagonal) {
    const double before = number;
    number += 1e-11;
    EXPECT_NONFATAL_FAILURE(expectDiagonalOf(matrix, diagonal), "matrix and diagonal differ");
    number = before;
  }
}

TEST(FieldUnderTest, DeformsTheWholeBody) {
  FieldUnderTest t(hexahedraScene("", true), "HexahedronFEMForceField");
  const std::vector<Vec3>& rest = t.field().state().rest_position;
  Vec3 low = rest[0], high = rest[0];
  for (const Vec3& place : rest) low = low.cwiseMin(place), high = high.cwiseMax(place);
  EXPECT_NEAR(t.typicalEdge(), (high - low).norm() / std::cbrt(60), 1e-15);

  t.deform(0);
  Eigen::Matrix<double, 3, Eigen::Dynamic> before(3, 59), after(3, 59);
  for (Index i = 1; i < 60; ++i)
    before.col(i - 1) = rest[std::size_t(i)] - rest[0], after.col(i - 1) = Vec3(t.x[i]) - Vec3(t.x[0]);
  const Mat3 gradient = after * before.transpose() * (before * before.transpose()).inverse();
  EXPECT_LT((after - gradient * before).norm(), 1e-12 * after.norm());
  const Vec3 stretches = Eigen::JacobiSVD<Mat3>(gradient).singularValues();
  EXPECT_GT(stretches[0] - stretches[2], 0.05);
  EXPECT_GT(gradient.determinant(), 0.3);
  EXPECT_GT((gradient - gradient.transpose()).norm(), 0.5) << "it is turned too";

  t.deform(0.1);
  for (Index i = 1; i < 60; ++i) before.col(i - 1) = Vec3(t.x[i]) - Vec3(t.x[0]);
  const double noise = (before - after).cwiseAbs().maxCoeff();
  EXPECT_LT(noise, 0.2 * t.typicalEdge());
  EXPECT_GT(noise, 0.1 * t.typicalEdge());
}

#ifdef __GLIBCXX__
TEST(FieldUnderTest, NumbersAreThoseOfTheLibrary) {
  std::mt19937 one(5), other(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int i = 0; i < 1000; ++i) ASSERT_DOUBLE_EQ(betweenOnes(one), uniform(other));
}
#endif

}  // namespace
}  // namespace stroma::test
