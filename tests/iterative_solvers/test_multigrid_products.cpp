// SPDX-License-Identifier: LGPL-2.1-or-later
// Multigrid whose finest level goes by products, as it does where these cost little: the answers are those of the matrix,
// iterations are few, also when the matrix has changed since the hierarchy was made, and runs repeat to the bit.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "framework/algebra/parallel.h"
#include "tests/iterative_solvers/block_problem.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

constexpr const char* multigrid = "<PCGLinearSolver preconditioner='multigrid'/>";

StoredMatrix cheapMatrixOf(const ElasticBlock& block) {
  StoredMatrix matrix = matrixOf(block);
  matrix.product_nanoseconds = 0.4 * double(matrix.values.blocks());
  return matrix;
}

/// |b - A x| / |b| by a plain sum over the blocks.
double residual(const StoredMatrix& matrix, ConstRows b, ConstRows x) {
  double sum = 0, all = 0;
  for (Index i = 0; i < matrix.rows(); ++i) {
    double rest[3];  // in numbers: compiled without optimisation
    for (int r = 0; r < 3; ++r) rest[r] = b.data[row_doubles * i + r];
    for (Index s = matrix.values.rowStart()[i], end = matrix.values.rowStart()[i + 1]; s < end; ++s) {
      const double *block = matrix.values.values().data() + 9 * s,
                   *other = x.data + row_doubles * matrix.values.columns()[s];
      for (int r = 0; r < 3; ++r)
        rest[r] -= block[3 * r] * other[0] + block[3 * r + 1] * other[1] + block[3 * r + 2] * other[2];
    }
    for (int r = 0; r < 3; ++r) sum += rest[r] * rest[r], all += std::pow(b.data[row_doubles * i + r], 2);
  }
  return std::sqrt(sum / all);
}

SolveReport solved(SolverInScene& solver, StoredMatrix& matrix, ConstRows b, Vector& x) {
  x = Vector(b.count);
  const SolveReport report = solver.solve(matrix, b, x);
  EXPECT_EQ(report.stop, SolveStop::converged) << describe(report.stop);
  EXPECT_LE(residual(matrix, b, x), 1.2e-8);
  return report;
}

TEST(MultigridByProducts, TheResidualIsThatOfTheMatrix) {
  const ElasticBlock block = box(2, 2, 2);
  const StoredMatrix matrix = matrixOf(block);
  const Vector b = weight(block), x = randomVector(block.count(), 3);
  const Eigen::VectorXd rest = dense(b) - matrix.dense() * dense(x);
  EXPECT_NEAR(residual(matrix, b, x) * dense(b).norm(), rest.norm(), 1e-12 * rest.norm());
}

TEST(MultigridByProducts, TakesNoMoreIterationsThanByBlocks) {
  ElasticBlock core = box(12, 12, 12), wall = box(8, 8, 8);
  core.stiffer = [](Vec3 at) { return std::abs(at.x() - 6) < 2 && std::abs(at.y() - 6) < 2 ? 1e4 : 1.; };
  wall.slide_wall = true;
  for (const ElasticBlock& block : {box(16, 16, 16), box(6, 6, 60), core, wall}) {
    StoredMatrix cheap = cheapMatrixOf(block), dear = matrixOf(block);
    SolverInScene by_products(multigrid), by_blocks(multigrid);
    Vector b = weight(block), x, y;
    for (Index row = 0; block.slide_wall && row < b.count(); row += block.nodes(0)) b[row].x() = 0;
    const int few = solved(by_products, cheap, b, x).iterations, usual = solved(by_blocks, dear, b, y).iterations;
    fmt::print("{} nodes: {} iterations by products, {} by blocks\n", b.count(), few, usual);
    EXPECT_LE(few, usual);
    EXPECT_GE(cheap.products, 7 * few) << "six of a V-cycle, and that of the iteration";
  }
}

/// The finest level is of the matrix as it is: rows that have become stiffer than the hierarchy knows them, as those of nodes in
/// contact do, get the diagonal blocks that they have now. They must not hide what the smoother has to bear.
TEST(MultigridByProducts, FollowsNodesThatBecomeStiff) {
  const ElasticBlock block = box(12, 12, 12);
  const Vector b = weight(block);
  for (const double stiffness : {3., 30., 1000.}) {
    StoredMatrix matrix = cheapMatrixOf(block);
    SolverInScene solver(multigrid);
    Vector x;
    const int before = solved(solver, matrix, b, x).iterations;
    for (const Index row : {Index(900), Index(1500), Index(2100)}) matrix.values.add(row, row, stiffness * Mat3::Identity());
    ++matrix.revision_number;
    const int after = solved(solver, matrix, b, x).iterations;
    fmt::print("three nodes stiffer by {}: {} iterations instead of {}\n", stiffness, after, before);
    EXPECT_LE(after, stiffness < 10 ? before + 5 : stiffness < 100 ? 3 * before : 8 * before);
  }
}

/// As with another time step.
TEST(MultigridByProducts, KnowsHowMuchStifferTheMatrixHasBecome) {
  const ElasticBlock block = box(12, 12, 12);
  const Vector b = weight(block);
  StoredMatrix matrix = cheapMatrixOf(block);
  SolverInScene solver(multigrid);
  Vector x;
  const int before = solved(solver, matrix, b, x).iterations;
  for (const double factor : {50., 1e-4}) {
    for (double& value : matrix.values.values()) value *= factor;
    ++matrix.revision_number;
    EXPECT_LE(solved(solver, matrix, b, x).iterations, before + 1) << factor;
  }
  EXPECT_EQ(matrix.assemblies, 1) << "a hierarchy was made anew";
}

TEST(MultigridByProducts, TurnsWithTheBodyAndRepeatsToTheBit) {
  const ElasticBlock block = box(14, 14, 14);
  StoredMatrix matrix = cheapMatrixOf(block);
  Vector b = weight(block), x, y;
  SolverInScene solver(multigrid), again(multigrid);
  const int fresh = solved(solver, matrix, b, x).iterations;
  handOver(solver, again, matrix);
  solved(solver, matrix, b, x), solved(again, matrix, b, y);
  EXPECT_EQ(std::memcmp(x.rows().data, y.rows().data, x.rows().doubles() * sizeof(double)), 0) << "of one matrix";
  const Mat3 turn = Eigen::AngleAxisd(1, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  for (std::size_t at = 0; at < matrix.values.values().size(); at += 9) {
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> value(matrix.values.values().data() + at);
    value = (turn * value * turn.transpose()).eval();
  }
  for (Index row = 0; row < b.count(); ++row) {
    matrix.nodes[std::size_t(row)] = turn * matrix.nodes[std::size_t(row)];
    b[row] = (turn * b[row]).eval();
  }
  ++matrix.revision_number;
  Vector turned;
  EXPECT_LE(solved(solver, matrix, b, turned).iterations, fresh + 1);
  for (Index row = 0; row < b.count(); ++row)
    EXPECT_LE((turned[row] - turn * x[row]).norm(), 1e-5 * norm(x)) << row;
  handOver(solver, again, matrix);
  for (const int count : {1, 2, 3}) {
    solved(solver, matrix, b, x);
    setThreads(count), solved(again, matrix, b, y), setThreads(1);
    EXPECT_EQ(std::memcmp(x.rows().data, y.rows().data, x.rows().doubles() * sizeof(double)), 0) << count << " threads";
    ++matrix.revision_number;
  }
  EXPECT_EQ(matrix.assemblies, 1);
}

/// Blocks that were given up are made again when products have become dear.
TEST(MultigridByProducts, GoesByBlocksWhereProductsAreDear) {
  const ElasticBlock block = box(10, 10, 10);
  StoredMatrix matrix = cheapMatrixOf(block);
  SolverInScene solver(multigrid);
  const Vector b = weight(block);
  Vector x;
  solved(solver, matrix, b, x);
  matrix.product_nanoseconds *= 10, matrix.products = 0;
  const int iterations = solved(solver, matrix, b, x).iterations;
  EXPECT_EQ(matrix.assemblies, 2);
  EXPECT_LE(matrix.products, iterations + 2);
}

/// A diagonal block that is not definite is named, and so is a matrix that is not where its diagonal is.
TEST(MultigridByProducts, NamesAMatrixThatHasBecomeIndefinite) {
  const ElasticBlock block = box(10, 10, 10);
  StoredMatrix matrix = cheapMatrixOf(block);
  SolverInScene solver(multigrid);
  const Vector b = weight(block);
  Vector x;
  solved(solver, matrix, b, x);
  matrix.values.add(700, 700, -1e4 * Mat3::Identity());
  ++matrix.revision_number;
  const SolveReport report = solver.solve(matrix, b, x);
  EXPECT_EQ(report.stop, SolveStop::not_definite) << describe(report.stop);
  EXPECT_EQ(report.row, 700);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
