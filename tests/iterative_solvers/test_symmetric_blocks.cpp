// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/iterative_solvers/symmetric_blocks.h"

#include <gtest/gtest.h>

#include "framework/algebra/parallel.h"
#include "tests/support/stored_matrix.h"

using namespace stroma;
using namespace stroma::test;

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// |y - A x| / |A x| of products with what `halves` keeps and with the matrix itself.
double productError(const SymmetricBlocks& halves, const BlockMatrix& matrix, ConstRows x) {
  Vector y = randomVector(matrix.rows(), 3), expected(matrix.rows());  // what was in y does not count
  halves.multiply(x, y);
  matrix.multiply(x, expected);
  double fourth = 0;
  for (Index i = 0; i < y.count(); ++i) fourth += std::abs(y.rows().data[4 * i + 3]);
  EXPECT_EQ(fourth, 0);
  axpy(-1, expected, y);
  return norm(y) / norm(expected);
}

TEST(SymmetricBlocks, MultiplyAsTheWholeMatrix) {
  for (const Index rows : {1, 2, 23, 8192}) {  // the last in two pieces
    const StoredMatrix matrix = randomMatrix(rows, 2, 0.1, 7);
    SymmetricBlocks halves;
    ASSERT_TRUE(halves.follow(matrix.values, matrix.key()));
    EXPECT_LT(productError(halves, matrix.values, randomVector(rows, 5)), 1e-15) << rows << " rows";
    if (rows < 8192) EXPECT_EQ(2 * halves.blocks(), matrix.values.blocks() + rows) << "mirrored blocks are kept once";
  }
}

TEST(SymmetricBlocks, HaveTheSameBitsForAnyNumberOfThreads) {
  constexpr Index rows = 12288;  // three pieces
  const StoredMatrix matrix = randomMatrix(rows, 1, 0.1, 7);
  const Vector x = randomVector(rows, 5);
  Vector first(rows), y(rows);
  for (const int count : {1, 2, 3}) {
    setThreads(count);
    SymmetricBlocks halves;
    ASSERT_TRUE(halves.follow(matrix.values, matrix.key()));
    halves.multiply(x, count == 1 ? first : y);
    setThreads(1);
    if (count > 1) EXPECT_EQ(std::memcmp(first.rows().data, y.rows().data, first.rows().doubles() * sizeof(double)), 0);
  }
}

TEST(SymmetricBlocks, FollowValuesAndPatterns) {
  StoredMatrix matrix = randomMatrix(23, 3, 0.1, 7);
  const Vector x = randomVector(23, 5);
  SymmetricBlocks halves;
  ASSERT_TRUE(halves.follow(matrix.values, matrix.key()));
  for (double& value : matrix.values.values()) value *= 3;
  EXPECT_GT(productError(halves, matrix.values, x), 0.5) << "nobody has said that values are others";
  ++matrix.revision_number;
  ASSERT_TRUE(halves.follow(matrix.values, matrix.key()));
  EXPECT_LT(productError(halves, matrix.values, x), 1e-15);
  for (const Index rows : {23, 17}) {
    matrix.values = randomMatrix(rows, 2, 0.1, 8).values;
    ++matrix.pattern_number;
    ASSERT_TRUE(halves.follow(matrix.values, matrix.key()));
    EXPECT_LT(productError(halves, matrix.values, randomVector(rows, 5)), 1e-15);
  }
}

TEST(SymmetricBlocks, RefuseAPatternThatIsNotSymmetric) {
  struct Case {
    bool has_chain;  // each row with the next
    std::vector<std::array<Index, 2>> alone;
  };
  const std::vector<Case> cases{{true, {{1, 4}}}, {true, {{4, 1}}}, {true, {{0, 6}}}, {true, {{6, 0}}}, {true, {{1, 4}, {4, 0}}},
                                {false, {{4, 1}}}, {false, {{1, 4}}}};
  for (std::size_t k = 0; k < cases.size(); ++k) {
    BlockPattern pattern(7);
    for (Index i = 0; i + 1 < 7 && cases[k].has_chain; ++i) pattern.addClique(std::array<Index, 2>{i, i + 1}.data(), 2);
    for (const auto& block : cases[k].alone) pattern.addBlock(block[0], block[1]);
    const BlockMatrix matrix(std::move(pattern));
    SymmetricBlocks halves;
    const int self = 0;
    EXPECT_FALSE(halves.follow(matrix, {&self, 1, 1})) << "case " << k;
    EXPECT_FALSE(halves.follow(matrix, {&self, 1, 2})) << "case " << k << " with other values";
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
