// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/iterative_solvers/conjugate_gradients.h"

#include <gtest/gtest.h>

#include "tests/support/stored_matrix.h"

using namespace stroma;
using namespace stroma::test;

TEST(ConjugateGradientLoops, EqualTheirUnfusedForms) {
  const Vector p0 = randomVector(101, 1), q = randomVector(101, 2), z = randomVector(101, 3);
  Vector p(101), x = randomVector(101, 4), r = randomVector(101, 5);
  copy(p0, p);
  const cg::Curvature curve = cg::curvature(p, q);
  EXPECT_NEAR(curve.pq, dense(p).dot(dense(q)), 1e-12);
  EXPECT_NEAR(curve.pp, dense(p).squaredNorm(), 1e-11);
  EXPECT_NEAR(curve.qq, dense(q).squaredNorm(), 1e-11);

  const Eigen::VectorXd r1 = dense(r) - 0.3 * dense(q), x1 = dense(x) + 0.7 * dense(p), p1 = dense(z) + 1.9 * dense(p);
  EXPECT_NEAR(cg::reduceResidual(0.3, q, r), r1.squaredNorm(), 1e-11);
  EXPECT_LT((dense(r) - r1).norm(), 1e-14 * r1.norm());
  cg::advance(0.7, 1.9, z, p, x);
  EXPECT_LT((dense(x) - x1).norm(), 1e-14 * x1.norm());
  EXPECT_LT((dense(p) - p1).norm(), 1e-14 * p1.norm());
}

TEST(BlockJacobi, DividesByTheDiagonalBlocks) {
  const StoredMatrix matrix = randomMatrix(23, 3, 0.1, 7);
  std::vector<double> blocks;
  matrix.diagonalBlocks(blocks);
  cg::BlockJacobi jacobi;
  ASSERT_EQ(jacobi.factor(blocks), -1);
  const Vector r = randomVector(23, 8);
  Vector z(23);
  const double product = jacobi.apply(r, z);
  EXPECT_NEAR(product, dense(r).dot(dense(z)), 1e-11 * std::abs(product));
  const Eigen::MatrixXd a = matrix.dense();
  for (Index i = 0; i < 23; ++i) EXPECT_LT((a.block<3, 3>(3 * i, 3 * i) * z[i] - r[i]).norm(), 1e-10);
}

TEST(BlockJacobi, NamesTheFirstBlockThatIsNotDefinite) {
  StoredMatrix matrix = randomMatrix(8, 2, 1, 3);
  matrix.values.add(5, 5, -100 * Mat3::Identity());
  std::vector<double> blocks;
  matrix.diagonalBlocks(blocks);
  EXPECT_EQ(cg::BlockJacobi().factor(blocks), 5);
}
