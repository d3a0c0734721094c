// SPDX-License-Identifier: LGPL-2.1-or-later
// Conjugate gradients with products in single precision: the answer has the tolerance that was asked for, a matrix that rounding
// would spoil is solved in double precision, and auto takes them where they do.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/solver_fixture.h"

using namespace stroma;
using namespace stroma::test;

namespace {

double residualOf(const StoredMatrix& matrix, ConstRows b, ConstRows x) {
  Vector r(b.count);
  matrix.values.multiply(x, r);
  axpy(-1, b, r);
  return norm(r) / norm(b);
}
const std::vector<std::string> solvers = {"CGLinearSolver", "PCGLinearSolver"};
std::string solverOf(const std::string& type, const std::string& attributes) {
  return "<" + type + " preconditioner=\"block_jacobi\" " + attributes + "/>";
}

}  // namespace

TEST(QuickProducts, ReachTheToleranceThatWasAskedFor) {
  for (const std::string& type : solvers)
    for (const char* tolerance : {"1e-3", "1e-5", "1e-8", "1e-12"}) {
      SCOPED_TRACE(type + " " + tolerance);
      StoredMatrix matrix = randomMatrix(400, 3, 1e-3, 5), exact = randomMatrix(400, 3, 1e-3, 5);
      matrix.single_nanoseconds = 1e5;
      const Vector b = randomVector(400, 6);
      SolverInScene quick(solverOf(type, std::string("precision=\"single\" tolerance=\"") + tolerance + "\""));
      SolverInScene plain(solverOf(type, std::string("precision=\"double\" tolerance=\"") + tolerance + "\""));
      Vector x, y;
      const SolveReport report = quick.solve(matrix, b, x), usual = plain.solve(exact, b, y);
      EXPECT_EQ(report.stop, SolveStop::converged);
      EXPECT_LE(residualOf(matrix, b, x), 1.2 * std::stod(tolerance));
      EXPECT_GT(matrix.single_products, report.iterations / 2) << "most products round";
      EXPECT_EQ(exact.single_products, 0);
      EXPECT_LE(report.iterations, 1.3 * usual.iterations + 2);
    }
}

TEST(QuickProducts, AreLeftWhereTheyAreTooFarOff) {
  for (const std::string& type : solvers)
    for (const double error : {0.5, 3.}) {  // a matrix that is not symmetric, and one that is not definite
      SCOPED_TRACE(type);
      StoredMatrix matrix = randomMatrix(60, 3, 1e-2, 7);
      matrix.single_nanoseconds = 1e5, matrix.single_error = error;
      const Vector b = randomVector(60, 8);
      SolverInScene quick(solverOf(type, "precision=\"single\" tolerance=\"1e-9\""));
      Vector x;
      const SolveReport report = quick.solve(matrix, b, x);
      EXPECT_EQ(report.stop, SolveStop::converged);
      EXPECT_LE(residualOf(matrix, b, x), 1.2e-9);
      EXPECT_GT(matrix.single_products, 0);
      EXPECT_LT(matrix.single_products, report.iterations);
    }
}

TEST(QuickProducts, AreTakenByLooseSolvesOfBodiesThatGainByThem) {
  struct Case {
    const char* attributes;
    double nanoseconds, relative_residual;
    bool is_single;
  };
  for (const std::string& type : solvers)
    for (const Case& c : {Case{"tolerance=\"1e-5\"", 1e5, 0, true}, Case{"tolerance=\"1e-6\"", 1e5, 0, false},
                          Case{"tolerance=\"1e-8\"", 1e5, 0.1, true}, Case{"iterations=\"25\" tolerance=\"1e-9\"", 1e5, 0, true},
                          Case{"iterations=\"26\" tolerance=\"1e-9\"", 1e5, 0, false},
                          Case{"tolerance=\"1e-5\"", 1e3, 0, false}, Case{"tolerance=\"1e-5\" precision=\"double\"", 1e5, 0, false},
                          Case{"tolerance=\"1e-9\" precision=\"single\"", 1e3, 0, true}}) {
      SCOPED_TRACE(type + " " + c.attributes);
      StoredMatrix matrix = randomMatrix(2600, 3, 0.1, 9);
      matrix.single_nanoseconds = c.nanoseconds;
      const Vector b = randomVector(2600, 10);
      SolverInScene solver(solverOf(type, c.attributes));
      Vector x(2600);
      solver.solver->solve(matrix, b, x, {.relative_residual = c.relative_residual});
      EXPECT_EQ(matrix.single_products > 0, c.is_single);
      if (c.relative_residual == 0) {
        EXPECT_EQ(!solver.solver->plan(matrix).empty(), c.is_single);
      }
    }
}
