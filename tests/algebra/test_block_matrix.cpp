// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <cmath>

#include "framework/algebra/parallel.h"
#include "tests/support/stored_matrix.h"

using namespace stroma;
using namespace stroma::test;

TEST(BlockMatrix, PatternIsSortedUniqueAndHasEveryDiagonal) {
  BlockPattern pattern(5);
  const Index clique[] = {3, 1, 3};
  pattern.addClique(clique, 3);
  pattern.addBlock(0, 4);
  pattern.addBlock(0, 4);
  const BlockMatrix matrix(std::move(pattern));
  EXPECT_EQ(matrix.rowStart(), (std::vector<Index>{0, 2, 4, 5, 7, 8}));
  EXPECT_EQ(matrix.columns(), (std::vector<Index>{0, 4, 1, 3, 2, 1, 3, 4}));
  EXPECT_EQ(matrix.diagonal(), (std::vector<Index>{0, 2, 4, 6, 7}));
  EXPECT_EQ(matrix.slot(3, 1), 5);
  EXPECT_EQ(matrix.slot(1, 0), -1);
  EXPECT_EQ(matrix.slot(4, 0), -1);
}

TEST(BlockMatrix, AnEmptyMatrixHasNoRows) {
  EXPECT_EQ(BlockMatrix(BlockPattern(0)).rows(), 0);
  EXPECT_EQ(BlockMatrix().blocks(), 0);
}

TEST(BlockMatrix, ProductEqualsDense) {
  const StoredMatrix matrix = randomMatrix(37, 4, 0.5, 1);
  const Vector x = randomVector(37, 2);
  Vector y = randomVector(37, 3);
  const Eigen::VectorXd before = dense(y), expected = matrix.dense() * dense(x);
  matrix.values.multiplyAdd(-0.5, x, y);
  EXPECT_LT((dense(y) - before + 0.5 * expected).norm(), 1e-13 * expected.norm());
  matrix.values.multiply(x, y);
  EXPECT_LT((dense(y) - expected).norm(), 1e-13 * expected.norm());
  for (Index i = 0; i < 37; ++i) EXPECT_EQ(y.rows().data[4 * i + 3], 0);
  EXPECT_GT(expected.norm(), 1);
}

TEST(BlockMatrix, ProductHasTheSameBitsOnAnyNumberOfThreads) {
  constexpr Index rows = 10001;  // more than two pieces
  BlockPattern pattern(rows);
  for (Index i = 0; i < rows; ++i)
    for (Index k = 0; k < i % 5; ++k) pattern.addBlock(i, (i * 7 + k * 1013) % rows);
  BlockMatrix matrix(std::move(pattern));
  for (std::size_t i = 0; i < matrix.values().size(); ++i) matrix.values()[i] = std::sin(double(i));
  const Vector x = randomVector(rows, 4);
  Vector expected(rows), sum(rows), y = randomVector(rows, 5);
  for (Index i = 0; i < rows; ++i)
    for (Index s = matrix.rowStart()[i]; s < matrix.rowStart()[i + 1]; ++s)
      for (int k = 0; k < 9; ++k)
        expected[i][k / 3] += matrix.values()[std::size_t(9 * s + k)] * x[matrix.columns()[s]][k % 3];
  const Vector before = randomVector(rows, 5);
  matrix.multiply(x, sum);
  matrix.multiplyAdd(2, x, y);
  setThreads(3);
  Vector shared(rows), added = randomVector(rows, 5);
  matrix.multiply(x, shared);
  matrix.multiplyAdd(2, x, added);
  setThreads(1);
  for (Index i = 0; i < rows; ++i) {
    EXPECT_EQ(sum[i], shared[i]) << i;
    EXPECT_EQ(y[i], added[i]) << i;
    EXPECT_LT((sum[i] - expected[i]).norm(), 1e-14) << i;
    EXPECT_LT((y[i] - before[i] - 2 * expected[i]).norm(), 1e-14) << i;
  }
}

TEST(BlockMatrix, ClearKeepsThePattern) {
  StoredMatrix matrix = randomMatrix(9, 2, 1, 5);
  const Index blocks = matrix.values.blocks();
  matrix.values.clear();
  EXPECT_EQ(matrix.values.blocks(), blocks);
  EXPECT_EQ(matrix.dense().norm(), 0);
}

/// Nanoseconds a block, with half of a symmetric matrix and with all of it: 0.9 and 1.05 in the caches, 2.1 and 3.5 from memory.
TEST(BlockMatrix, ProductsCostWhatTheyTook) {
  const auto each = [](double blocks, bool is_halved) { return BlockMatrix::productCost(blocks, is_halved) / blocks; };
  EXPECT_NEAR(each(58e3, true), 0.9, 0.1);
  EXPECT_NEAR(each(58e3, false), 1.05, 0.1);
  EXPECT_NEAR(each(1.2e6, true), 2.1, 0.2);
  EXPECT_NEAR(each(1.2e6, false), 3.5, 0.2);
}
