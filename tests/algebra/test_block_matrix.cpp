// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

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

TEST(BlockMatrix, ClearKeepsThePattern) {
  StoredMatrix matrix = randomMatrix(9, 2, 1, 5);
  const Index blocks = matrix.values.blocks();
  matrix.values.clear();
  EXPECT_EQ(matrix.values.blocks(), blocks);
  EXPECT_EQ(matrix.dense().norm(), 0);
}
