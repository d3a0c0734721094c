// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/solver_fixture.h"

using namespace stroma;
using namespace stroma::test;

namespace {

/// A diagonal matrix with the given values, one per row, cycling.
StoredMatrix diagonalMatrix(Index rows, const std::vector<double>& values) {
  BlockMatrix matrix{BlockPattern(rows)};
  for (Index i = 0; i < rows; ++i) matrix.add(i, i, values[std::size_t(i) % values.size()] * Mat3::Identity());
  return StoredMatrix(std::move(matrix));
}

/// Textbook conjugate gradients, stopped after `iterations` products.
Eigen::VectorXd textbook(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, int iterations) {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(b.size()), r = b, p = r;
  for (int i = 0; i < iterations; ++i) {
    const Eigen::VectorXd q = a * p;
    const double rho = r.squaredNorm(), alpha = rho / p.dot(q);
    x += alpha * p;
    r -= alpha * q;
    p = r + r.squaredNorm() / rho * p;
  }
  return x;
}

}  // namespace

TEST(CGLinearSolver, SolvesRandomSystemsToTheToleranceAskedFor) {
  for (const char* preconditioner : {"none", "block_jacobi"})
    for (unsigned seed = 1; seed < 5; ++seed) {
      StoredMatrix matrix = randomMatrix(60, 3, 0.3, seed);
      const Vector b = randomVector(60, seed + 10);
      SolverInScene cg(
          std::string("<CGLinearSolver iterations=\"1000\" tolerance=\"1e-12\" threshold=\"1e-9\" preconditioner=\"") +
          preconditioner + "\"/>");
      Vector x;
      const SolveReport report = cg.solve(matrix, b, x);
      EXPECT_EQ(report.stop, SolveStop::converged);
      EXPECT_LE(report.relative_residual, 1e-12);
      const Eigen::VectorXd exact = denseSolution(matrix.dense(), dense(b));
      EXPECT_LT(relativeError(x, exact), 1e-10);
      const Eigen::VectorXd residual = dense(b) - matrix.dense() * dense(x);
      EXPECT_NEAR(residual.norm() / dense(b).norm(), report.relative_residual, 1e-13);
    }
}

TEST(CGLinearSolver, EveryIterateIsThatOfTheTextbook) {
  StoredMatrix matrix = randomMatrix(40, 3, 0.1, 3);
  const Vector b = randomVector(40, 4);
  for (int iterations = 1; iterations <= 8; ++iterations) {
    SolverInScene cg("<CGLinearSolver tolerance=\"1e-30\" threshold=\"1e-9\" iterations=\"" +
                     std::to_string(iterations) + "\"/>");
    Vector x;
    const SolveReport report = cg.solve(matrix, b, x);
    EXPECT_EQ(report.stop, SolveStop::iteration_limit);
    EXPECT_EQ(report.iterations, iterations);
    EXPECT_EQ(matrix.products, iterations);
    matrix.products = 0;
    const Eigen::VectorXd expected = textbook(matrix.dense(), dense(b), iterations);
    EXPECT_LT(relativeError(x, expected), 1e-11);
    EXPECT_NEAR(report.relative_residual, (dense(b) - matrix.dense() * expected).norm() / dense(b).norm(), 1e-10);
    EXPECT_EQ(cg.reals("graph").size(), std::size_t(iterations));
  }
}

TEST(CGLinearSolver, NeedsAsManyIterationsAsThereAreDistinctEigenvalues) {
  for (int distinct = 1; distinct <= 5; ++distinct) {
    std::vector<double> values;
    for (int k = 0; k < distinct; ++k) values.push_back(1 + k);
    StoredMatrix matrix = diagonalMatrix(30, values);
    const Vector b = randomVector(30, 1);
    SolverInScene cg("<CGLinearSolver iterations=\"50\" tolerance=\"1e-10\"/>");
    Vector x;
    EXPECT_EQ(cg.solve(matrix, b, x).iterations, distinct);
    SolverInScene preconditioned(
        "<CGLinearSolver iterations=\"50\" tolerance=\"1e-10\" preconditioner=\"block_jacobi\"/>");
    x = Vector();
    EXPECT_EQ(preconditioned.solve(matrix, b, x).iterations, 1);
  }
}

TEST(CGLinearSolver, DoesNotDependOnTheUnits) {
  // the absolute threshold of 1e-5 on p.A p would stop the small one at its first iteration
  int iterations = 0;
  for (const double unit : {1.0, 1e-30, 1e30}) {
    StoredMatrix matrix = randomMatrix(40, 3, 0.2, 6);
    for (double& value : matrix.values.values()) value *= unit;
    Vector b = randomVector(40, 7);
    scale(std::sqrt(unit), b);
    SolverInScene cg("<CGLinearSolver iterations=\"500\" tolerance=\"1e-8\"/>");
    Vector x;
    const SolveReport report = cg.solve(matrix, b, x);
    EXPECT_EQ(report.stop, SolveStop::converged);
    if (iterations == 0) iterations = report.iterations;
    EXPECT_NEAR(report.iterations, iterations, 1);
  }
  EXPECT_GT(iterations, 10);
}

/// The first solve of a run makes an iteration whatever SOFA's threshold says. A step that was taken back is no solve.
TEST(CGLinearSolver, TheFirstSolveIsTheFirstAgainAfterItsStepWasTakenBack) {
  StoredMatrix matrix = randomMatrix(40, 3, 0.2, 6);
  const Vector b = randomVector(40, 7);
  SolverInScene cg("<CGLinearSolver iterations='50' tolerance='1e-8' absoluteThreshold='1e30'/>");
  cg.solver->keepFor(matrix);
  for (int again = 0; again < 2; ++again) {
    Vector x;
    cg.solve(matrix, b, x);
    EXPECT_GT(norm(x), 0) << again;
    if (again == 0) cg.solver->takeBackFor(matrix);
  }
  Vector x;
  cg.solve(matrix, b, x);
  EXPECT_EQ(norm(x), 0);
}

TEST(CGLinearSolver, APreconditionerHelpsABadlyScaledMatrix) {
  StoredMatrix matrix = randomMatrix(50, 3, 1, 9);
  for (Index i = 0; i < 50; ++i) matrix.values.add(i, i, std::pow(10, i % 6) * Mat3::Identity());
  const Vector b = randomVector(50, 2);
  Vector x;
  SolverInScene plain("<CGLinearSolver iterations=\"5000\" tolerance=\"1e-9\"/>");
  const int without = plain.solve(matrix, b, x).iterations;
  SolverInScene preconditioned(
      "<CGLinearSolver iterations=\"5000\" tolerance=\"1e-9\" preconditioner=\"block_jacobi\"/>");
  x = Vector();
  const int with = preconditioned.solve(matrix, b, x).iterations;
  EXPECT_LT(3 * with, without);
}

TEST(CGLinearSolver, AZeroRightSideGivesZeroWithoutWork) {
  StoredMatrix matrix = randomMatrix(10, 2, 1, 1);
  SolverInScene cg("<CGLinearSolver/>");
  Vector x = randomVector(10, 1);
  const SolveReport report = cg.solve(matrix, Vector(10).rows(), x);
  EXPECT_EQ(report.stop, SolveStop::zero_right_side);
  EXPECT_TRUE(report.usable());
  EXPECT_EQ(dot(x, x), 0);
  EXPECT_EQ(matrix.products, 0);
}

TEST(CGLinearSolver, SaysWhyItStopped) {
  SolverInScene cg("<CGLinearSolver iterations=\"100\" tolerance=\"1e-12\"/>");
  const Vector b = randomVector(12, 1);
  const auto stopOf = [&](StoredMatrix matrix, ConstRows right) {
    Vector x;
    return cg.solve(matrix, right, x).stop;
  };
  EXPECT_EQ(stopOf(diagonalMatrix(12, {1, -1, 2}), b), SolveStop::not_definite);
  EXPECT_EQ(stopOf(diagonalMatrix(12, {-1}), b), SolveStop::not_definite);
  EXPECT_EQ(stopOf(diagonalMatrix(12, {0}), b), SolveStop::breakdown);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(stopOf(diagonalMatrix(12, {1, nan}), b), SolveStop::not_finite);
  Vector bad = randomVector(12, 1);
  bad[3][1] = nan;
  EXPECT_EQ(stopOf(diagonalMatrix(12, {1}), bad), SolveStop::not_finite);
  SolverInScene jacobi("<CGLinearSolver preconditioner=\"block_jacobi\"/>");
  StoredMatrix matrix = diagonalMatrix(12, {1, 1, -1});
  Vector x;
  const SolveReport report = jacobi.solve(matrix, b, x);
  EXPECT_EQ(report.stop, SolveStop::not_definite);
  EXPECT_EQ(report.row, 2);
}

TEST(CGLinearSolver, KeepsTheIterateBeforeABreakdown) {
  // two steps are possible before the negative direction is met; the iterate then goes downhill
  StoredMatrix matrix = randomMatrix(30, 3, 0.5, 12);
  matrix.values.add(4, 4, -60 * Mat3::Identity());
  Vector b = randomVector(30, 3);
  b[4].setZero();
  SolverInScene cg("<CGLinearSolver iterations=\"100\" tolerance=\"1e-12\"/>");
  Vector x;
  const SolveReport report = cg.solve(matrix, b, x);
  EXPECT_EQ(report.stop, SolveStop::not_definite);
  EXPECT_FALSE(report.usable());
  ASSERT_GT(report.iterations, 1);
  EXPECT_GT(dot(x, b), 0);
  EXPECT_LT(relativeError(x, textbook(matrix.dense(), dense(b), report.iterations - 1)), 1e-11);
}

TEST(CGLinearSolver, WarmStartBeginsAtThePreviousSolution) {
  StoredMatrix matrix = randomMatrix(30, 3, 0.5, 2);
  const Vector b = randomVector(30, 3);
  SolverInScene cg("<CGLinearSolver iterations=\"500\" tolerance=\"1e-8\" warmStart=\"true\"/>");
  Vector x(30);
  const SolveReport first = cg.solve(matrix, b, x);
  EXPECT_GT(first.iterations, 5);
  clear(x);
  const SolveReport second = cg.solve(matrix, b, x);
  EXPECT_EQ(second.iterations, 0);
  EXPECT_LE(second.relative_residual, 1e-8);
  cg.solver->reset();
  clear(x);
  EXPECT_EQ(cg.solve(matrix, b, x).iterations, first.iterations);
}

TEST(CGLinearSolver, TheTemplateChoosesProductOrMatrix) {
  const Vector b = randomVector(20, 3);
  const auto count = [&](const std::string& attributes, bool prefers, int& products, int& assemblies) {
    StoredMatrix matrix = randomMatrix(20, 2, 1, 2);
    matrix.prefers_assembled = prefers;
    SolverInScene cg("<CGLinearSolver " + attributes + "/>");
    Vector x;
    cg.solve(matrix, b, x);
    products = matrix.products;
    assemblies = matrix.assemblies;
  };
  int products = 0, assemblies = 0;
  for (const bool prefers : {false, true}) {
    count("template=\"GraphScattered\"", prefers, products, assemblies);
    EXPECT_GT(products, 0);
    EXPECT_EQ(assemblies, 0);
    count("template=\"CompressedRowSparseMatrixMat3x3d\"", prefers, products, assemblies);
    EXPECT_EQ(products, 0);
    EXPECT_EQ(assemblies, 1);
    count("", prefers, products, assemblies);
    EXPECT_EQ(products == 0, prefers);
    EXPECT_EQ(assemblies, prefers ? 1 : 0);
  }
}

TEST(CGLinearSolver, RefusesWhatItDoesNotHave) {
  EXPECT_NE(
      problemsOf("<Node name=\"root\"><CGLinearSolver template=\"GraphScatered\"/></Node>").find("GraphScattered"),
      std::string::npos);
  EXPECT_NE(problemsOf("<Node name=\"root\"><CGLinearSolver preconditioner=\"jacobi\"/></Node>").find("block_jacobi"),
            std::string::npos);
  EXPECT_NE(problemsOf("<Node name=\"root\"><CGLinearSolver iterations=\"0\"/></Node>").find("iterations"),
            std::string::npos);
}

namespace {

std::string twoBodies(const std::string& bodies, const std::string& tie) {
  return "<Node name='root'><EulerImplicitSolver/><CGLinearSolver preconditioner='none' bodies='" + bodies +
         "'/><Node name='a'><MechanicalObject name='dofs' position='0 0 0  1 0 0'/><UniformMass totalMass='1'/>" + tie +
         "</Node><Node name='b'><MechanicalObject name='dofs' position='0 0 0  1 0 0'/><UniformMass totalMass='3'/></Node></Node>";
}

}  // namespace

TEST(CGLinearSolver, BodiesAreThereAndApart) {
  EXPECT_EQ(problemsOf(twoBodies("/a /b", "")), "");
  expectContains(problemsOf(twoBodies("/a /nope", "")), "no node /nope with a mechanical state");
  expectContains(problemsOf(twoBodies("/a /c", "<Node name='c'/>")), "no node /c with a mechanical state");
  expectContains(problemsOf(twoBodies("/a /a", "")), "/a is there twice");
  const std::string inner = "<Node name='c'><MechanicalObject position='0 0 0'/><UniformMass totalMass='1'/></Node>";
  expectContains(problemsOf(twoBodies("/a /a/c", inner)), "/a/c is within /a");
}

TEST(CGLinearSolver, RefusesToSolveTiedBodiesApart) {
  const std::string spring = "<SpringForceField object1='@/a/dofs' object2='@/b/dofs' spring='0 1 1e5 0 0.5'/>";
  for (const auto& [bodies, tie] : std::vector<std::pair<std::string, std::string>>{{"/a", ""}, {"/a", spring}, {"/a /b", spring}}) {
    SCOPED_TRACE(bodies + " " + tie);
    Simulation simulation = simulationFromText(twoBodies(bodies, tie));
    std::string said;
    try {
      simulation.step();
    } catch (const ComponentError& error) {
      said = error.what();
    }
    if (tie.empty())
      EXPECT_EQ(said, "");
    else
      expectContains(said, "something ties node 0 of /a/dofs to node 1 of /b/dofs");
  }
}
