// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/iterative_solvers/conjugate_gradients.h"
#include "components/iterative_solvers/preconditioned_conjugate_gradients.h"

#include <gtest/gtest.h>

#include "tests/support/stored_matrix.h"

using namespace stroma;
using namespace stroma::test;

TEST(ConjugateGradientLoops, EqualTheirUnfusedForms) {
  for (const Index rows : {101, 70001}) {  // in one piece and in four
    const Vector p0 = randomVector(rows, 1), q = randomVector(rows, 2), z = randomVector(rows, 3);
    Vector p(rows), x = randomVector(rows, 4), r = randomVector(rows, 5);
    copy(p0, p);
    const cg::Curvature curve = cg::curvature(p, q);
    const double size = dense(p).norm() * dense(q).norm();
    EXPECT_NEAR(curve.pq, dense(p).dot(dense(q)), 1e-14 * size);
    EXPECT_NEAR(curve.pp, dense(p).squaredNorm(), 1e-13 * size);
    EXPECT_NEAR(curve.qq, dense(q).squaredNorm(), 1e-13 * size);
    EXPECT_NEAR(cg::inner(p, q), dense(p).dot(dense(q)), 1e-14 * size);

    const Eigen::VectorXd r1 = dense(r) - 0.3 * dense(q), x1 = dense(x) + 0.7 * dense(p), p1 = dense(z) + 1.9 * dense(p);
    EXPECT_NEAR(cg::reduceResidual(0.3, q, r), r1.squaredNorm(), 1e-13 * size);
    EXPECT_LT((dense(r) - r1).norm(), 1e-14 * r1.norm());
    cg::advance(0.7, 1.9, z, p, x);
    EXPECT_LT((dense(x) - x1).norm(), 1e-14 * x1.norm());
    EXPECT_LT((dense(p) - p1).norm(), 1e-14 * p1.norm());
  }
}

// Where residuals are measured by the preconditioner, its first step is what measured the right side: an application for each iteration
// and one at the end. The numbers are the same as without.
TEST(ConjugateGradientLoops, WhatMeasuresTheForcesIsTheFirstStep) {
  const StoredMatrix matrix = randomMatrix(40, 3, 0.5, 3);
  const Vector b = randomVector(40, 1);
  std::vector<double> blocks;
  matrix.diagonalBlocks(blocks);
  cg::BlockJacobi jacobi;
  ASSERT_EQ(jacobi.factor(blocks), -1);
  const auto solve = [&](bool has_step, bool from_zero) {
    int applications = 0;
    const auto multiply = [&](ConstRows p, Rows out) { matrix.multiply(p, out); };
    const auto precondition = [&](ConstRows r, Rows z) { ++applications, jacobi.apply(r, z); };
    cg::Directions work;
    work.resize(40);
    Vector x(40);
    if (!from_zero) x[3] = Vec3(1, 2, 3);
    precondition(b, work.z);
    const double size = std::sqrt(cg::inner(b, work.z));
    const cg::Limits limits{200, 1e-8 * size, {}, true};
    const SolveReport report = cg::preconditioned(multiply, precondition, [](double) {}, limits, b, work, x, false, has_step);
    EXPECT_EQ(report.stop, SolveStop::converged);
    return std::pair(applications - report.iterations, dense(x).eval());
  };
  const auto with = solve(true, true), without = solve(false, true), moved = solve(true, false);
  EXPECT_EQ(with.first, 2);
  EXPECT_EQ(without.first, 3);
  EXPECT_EQ(moved.first, 3) << "of another residual";
  EXPECT_EQ(with.second, without.second);
  EXPECT_LT((moved.second - with.second).norm(), 1e-6 * with.second.norm());
}

// Each row belongs to one piece, whatever the number of rows.
TEST(ConjugateGradientLoops, PiecesCoverAVector) {
  for (const Index rows : {0, 1, 32767, 32768, 49153, 2000001}) {
    Index next = 0;
    int pieces = 0;
    cg::forPieces(rows, [&](int k, Index first, Index size) {
      EXPECT_EQ(k, pieces++);
      EXPECT_EQ(first, next);
      EXPECT_EQ(first % 2, 0) << "not at the start of a cache line";
      next = first + size;
    });
    EXPECT_EQ(next, rows);
    EXPECT_EQ(pieces, cg::piecesOf(rows));
  }
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
