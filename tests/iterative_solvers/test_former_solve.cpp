// SPDX-License-Identifier: LGPL-2.1-or-later
// What factors of a former matrix, and its solution, say of the next one.
#include <gtest/gtest.h>

#include <cmath>

#include "components/iterative_solvers/former_solve.h"
#include "tests/iterative_solvers/automatic_problems.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// What the turned factors of a former matrix leave of its own solve.
TEST(FormerSolve, DriftIsThatOfTheMatrix) {
  Beam beam(0.2);
  SolverInScene solver("<PCGLinearSolver tolerance='1e-12' preconditioner='block_jacobi'/>");
  beam.solve(solver);
  FormerSolve former;
  former.keep(beam.matrix, 1, beam.b, beam.x);
  EXPECT_LT(former.drift(beam.matrix), 1e-9);
  // A + 0.1 A leaves r = 0.1 b, in the norm of 1.1 D
  double sum = 0;
  std::vector<double> blocks;
  beam.matrix.diagonalBlocks(blocks);
  for (Index i = 0; i < beam.b.count(); ++i)
    sum += Vec3(beam.b[i]).dot(Eigen::Map<const Mat3>(blocks.data() + 9 * std::size_t(i)).inverse() * Vec3(beam.b[i]));
  for (double& value : beam.matrix.values.values()) value *= 1.1;
  EXPECT_NEAR(former.drift(beam.matrix), 0.1 * std::sqrt(sum / 1.1 / dot(beam.x, beam.b)), 1e-9);
  for (double& value : beam.matrix.values.values()) value /= 1.1;
  // and one that is turned with its nodes has not drifted
  const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  for (Vec3& node : beam.matrix.nodes) node = turn * node;
  for (std::size_t s = 0; s < beam.matrix.values.values().size() / 9; ++s) {
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> block(beam.matrix.values.values().data() + 9 * s);
    block = (turn * block * turn.transpose()).eval();
  }
  EXPECT_LT(former.drift(beam.matrix), 1e-3);
  Drifts drifts;
  drifts.note(1, 0.01);
  EXPECT_NEAR(drifts.after(5), 0.05, 1e-12);
  drifts.note(3, 0.02);
  EXPECT_NEAR(drifts.after(5), 0.03, 1e-12);
}

/// Factors that never serve the next matrix are made for each one, instead of a trial with every second one.
TEST(WarpedFactor, MatricesThatFactorsDoNotServeAreFactoredAtOnce) {
  Needle needle;
  SolverInScene solver("<PCGLinearSolver preconditioner='warped'/><SparseLDLSolver/>");
  int slow = 0;
  for (int step = 0; step < 30; ++step) slow += needle.solve(solver).iterations > 8;
  EXPECT_GT(slow, 0);
  EXPECT_LT(slow, 6);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
