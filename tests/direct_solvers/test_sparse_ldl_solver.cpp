// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <limits>

#include "framework/algebra/parallel.h"
#include "tests/support/solver_fixture.h"

using namespace stroma;
using namespace stroma::test;

TEST(SparseLDLSolver, EqualsADenseFactorisation) {
  for (unsigned seed = 1; seed < 6; ++seed) {
    StoredMatrix matrix = randomMatrix(Index(5 + 40 * seed), 3, 0.05, seed);
    const Vector b = randomVector(matrix.rows(), seed);
    SolverInScene ldl("<SparseLDLSolver/>");
    Vector x;
    const SolveReport report = ldl.solve(matrix, b, x);
    EXPECT_EQ(report.stop, SolveStop::converged);
    EXPECT_TRUE(report.factored);
    EXPECT_LT(report.relative_residual, 1e-10);
    EXPECT_LT(relativeError(x, denseSolution(matrix.dense(), dense(b))), 1e-9);
  }
}

TEST(SparseLDLSolver, FactorsAgainOnlyWhenTheMatrixChanged) {
  StoredMatrix matrix = randomMatrix(50, 3, 0.5, 1);
  SolverInScene ldl("<SparseLDLSolver/>");
  Vector x;
  EXPECT_TRUE(ldl.solve(matrix, randomVector(50, 1), x).factored);
  EXPECT_FALSE(ldl.solve(matrix, randomVector(50, 2), x).factored);
  const Vector b = randomVector(50, 3);
  EXPECT_FALSE(ldl.solve(matrix, b, x).factored);
  EXPECT_LT(relativeError(x, denseSolution(matrix.dense(), dense(b))), 1e-10);
  matrix.values.add(3, 3, Mat3::Identity());
  ++matrix.revision_number;
  EXPECT_TRUE(ldl.solve(matrix, b, x).factored);
  EXPECT_LT(relativeError(x, denseSolution(matrix.dense(), dense(b))), 1e-10);
  EXPECT_EQ(*std::get<int*>(ldl.solver->data().find("factorisations")->pointer()), 2);
}

/// A matrix without zeros: n (n + 1) / 2 numbers in the factor, and n^3 / 3 operations and some that grow as n^2.
TEST(SparseLDLSolver, TellsWhatAFactorisationCosts) {
  constexpr Index blocks = 40;
  constexpr double n = 3 * blocks;
  BlockPattern pattern(blocks);
  for (Index i = 0; i < blocks; ++i)
    for (Index j = 0; j < blocks; ++j) pattern.addBlock(i, j);
  BlockMatrix values{std::move(pattern)};
  for (Index i = 0; i < blocks; ++i)
    for (Index j = 0; j < blocks; ++j) values.add(i, j, (i == j ? 100.0 : 1.0) * Mat3::Identity());
  StoredMatrix matrix(std::move(values));
  SolverInScene ldl("<SparseLDLSolver/>");
  Vector x;
  ldl.solve(matrix, randomVector(matrix.rows(), 1), x);
  const auto told = [&ldl](const char* name) { return *std::get<double*>(ldl.solver->data().find(name)->pointer()); };
  EXPECT_EQ(told("factorEntries"), n * (n + 1) / 2);
  EXPECT_NEAR(told("factorFlops"), n * n * n / 3, 2 * n * n);
}

TEST(SparseLDLSolver, FollowsAPatternThatChanges) {
  SolverInScene ldl("<SparseLDLSolver/>");
  Vector x;
  for (const unsigned seed : {1u, 2u}) {
    StoredMatrix matrix = randomMatrix(40, 3, 0.5, seed);  // the same revision number, another pattern
    const Vector b = randomVector(40, 3);
    EXPECT_TRUE(ldl.solve(matrix, b, x).factored);
    EXPECT_LT(relativeError(x, denseSolution(matrix.dense(), dense(b))), 1e-10);
  }
}

TEST(SparseLDLSolver, AnalysesAgainWhenBlocksHaveComeToTheSameMatrix) {
  SolverInScene ldl("<SparseLDLSolver/>");
  StoredMatrix matrix = randomMatrix(40, 3, 0.5, 1);
  Vector x;
  const Vector b = randomVector(40, 3);
  ldl.solve(matrix, b, x);
  matrix.values = randomMatrix(40, 5, 0.5, 2).values;
  ++matrix.pattern_number, ++matrix.revision_number;
  EXPECT_TRUE(ldl.solve(matrix, b, x).factored);
  EXPECT_LT(relativeError(x, denseSolution(matrix.dense(), dense(b))), 1e-10);
  matrix.is_symmetric = false;  // the same numbers, which are taken as unsymmetric from now on
  EXPECT_TRUE(ldl.solve(matrix, b, x).factored);
  EXPECT_LT(relativeError(x, denseSolution(matrix.dense(), dense(b))), 1e-10);
}

/// A matrix of the same pattern takes over the factors of a former one, with their analysis and their memory.
TEST(SparseLDLSolver, HandsFactorsOverToAnotherMatrix) {
  StoredMatrix former = randomMatrix(40, 3, 0.5, 1), matrix = randomMatrix(40, 3, 0.5, 1), other = randomMatrix(50, 3, 0.5, 2);
  for (Index i = 0; i < matrix.rows(); ++i) matrix.values.add(i, i, Mat3::Identity());
  SolverInScene solver("<SparseLDLSolver/>");
  auto& direct = dynamic_cast<DirectSolver&>(*solver.solver);
  const auto factorsOf = [&](StoredMatrix& of) {
    SolveReport report;
    return direct.factor(of, report, {});
  };
  const auto expectSolved = [&](StoredMatrix& of) {
    const Vector b = randomVector(of.rows(), 4);
    Vector x;
    EXPECT_EQ(solver.solve(of, b, x).stop, SolveStop::converged);
    EXPECT_LT(relativeError(x, of.dense().lu().solve(dense(b))), 1e-10);
  };
  direct.handOver(former, matrix);  // there are none so far
  Factorisation* const made = factorsOf(former);
  direct.handOver(former, matrix);
  EXPECT_EQ(factorsOf(matrix), made);
  expectSolved(matrix), expectSolved(former);
  Factorisation* const again = factorsOf(former);
  EXPECT_NE(again, made) << "the former matrix has factors of its own once they are asked for";
  direct.handOver(former, matrix);
  EXPECT_EQ(factorsOf(matrix), made) << "a matrix that has factors keeps them";
  direct.handOver(former, other);
  EXPECT_EQ(factorsOf(other), again);
  expectSolved(other), expectSolved(matrix);
}

TEST(SparseLDLSolver, NamesTheRowWhereTheMatrixIsNotDefinite) {
  for (const Index row : {0, 7, 29}) {
    BlockMatrix values{BlockPattern(30)};
    for (Index i = 0; i < 30; ++i) values.add(i, i, (i == row ? -1.0 : 2.0) * Mat3::Identity());
    StoredMatrix matrix(std::move(values));
    SolverInScene ldl("<SparseLDLSolver/>");
    Vector x;
    const SolveReport report = ldl.solve(matrix, randomVector(30, 1), x);
    EXPECT_EQ(report.stop, SolveStop::not_definite);
    EXPECT_EQ(report.row, row);
    EXPECT_FALSE(report.usable());
    matrix.values.add(row, row, 5 * Mat3::Identity());
    ++matrix.revision_number;
    EXPECT_EQ(ldl.solve(matrix, randomVector(30, 1), x).stop, SolveStop::converged);
  }
}

TEST(SparseLDLSolver, NamesTheRowThatIsNotFinite) {
  StoredMatrix matrix = randomMatrix(30, 3, 0.5, 1);
  matrix.values.add(11, 11, std::numeric_limits<double>::quiet_NaN() * Mat3::Ones());
  SolverInScene ldl("<SparseLDLSolver/>");
  Vector x;
  const SolveReport report = ldl.solve(matrix, randomVector(30, 1), x);
  EXPECT_EQ(report.stop, SolveStop::not_finite);
  EXPECT_EQ(report.row, 11);
  Vector bad = randomVector(30, 1);
  bad[2][0] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(ldl.solve(matrix, bad, x).stop, SolveStop::not_finite);
}

TEST(SparseLDLSolver, ASingularMatrixIsNotSolvedSilently) {
  // without ground the chain can move as a whole
  BlockPattern pattern(20);
  for (Index i = 0; i + 1 < 20; ++i) {
    const Index pair[] = {i, i + 1};
    pattern.addClique(pair, 2);
  }
  BlockMatrix values(std::move(pattern));
  for (Index i = 0; i + 1 < 20; ++i)
    for (int p = 0; p < 2; ++p)
      for (int q = 0; q < 2; ++q) values.add(i + p, i + q, (p == q ? 1.0 : -1.0) * Mat3::Identity());
  StoredMatrix matrix(std::move(values));
  SolverInScene ldl("<SparseLDLSolver/>");
  Vector x;
  EXPECT_FALSE(ldl.solve(matrix, randomVector(20, 1), x).usable());
}

/// A part that is not symmetric: small, and larger than the rest. The one is met by products with factors of the
/// symmetric part, the other (and an indefinite symmetric part) by L U; both are as exact.
TEST(SparseLDLSolver, SolvesUnsymmetricMatricesOfAnySize) {
  for (const double size : {0.01, 0.3, 50.})
    for (const double ground : {0.5, -40.}) {
      StoredMatrix matrix = randomMatrix(40, 3, ground, 3);
      for (Index i = 0; i < 40; ++i)
        matrix.values.add(i, i, size * (Mat3() << 0, 1, 2, -1, 0, 3, -2, -3, 0).finished());
      matrix.is_symmetric = false;
      SolverInScene ldl("<SparseLDLSolver/>");
      Vector x;
      for (const unsigned seed : {1u, 2u}) {
        const Vector b = randomVector(40, seed);
        EXPECT_EQ(ldl.solve(matrix, b, x).stop, SolveStop::converged) << size << " " << ground;
        EXPECT_LT(relativeError(x, matrix.dense().partialPivLu().solve(dense(b))), 1e-10) << size << " " << ground;
      }
      const std::string ordering = ldl.solver->data().find("ordering")->print();
      // of a definite symmetric part it is known only when products have failed
      EXPECT_EQ(ordering == "COLAMD", ground < 0) << "an indefinite symmetric part is of no use: " << size;
    }
}

TEST(SparseLDLSolver, FactorsAnUnsymmetricMatrix) {
  StoredMatrix matrix = randomMatrix(40, 3, 0.5, 3);
  for (Index i = 0; i < 40; ++i) matrix.values.add(i, i, (Mat3() << 0, 1, 2, -1, 0, 3, -2, -3, 0).finished());
  matrix.is_symmetric = false;
  const Vector b = randomVector(40, 1);
  SolverInScene ldl("<SparseLDLSolver/>");
  Vector x;
  const SolveReport report = ldl.solve(matrix, b, x);
  EXPECT_EQ(report.stop, SolveStop::converged);
  EXPECT_LT(relativeError(x, denseSolution(matrix.dense(), dense(b))), 1e-10);
  EXPECT_FALSE(ldl.solve(matrix, b, x).factored);
}

TEST(SparseLDLSolver, TheSolutionDoesNotDependOnTheNumberOfThreads) {
  StoredMatrix matrix = randomMatrix(900, 4, 0.5, 3);
  const Vector b = randomVector(900, 1);
  Vector x[2];
  for (const int count : {1, 2}) {
    setThreads(count);
    SolverInScene ldl("<SparseLDLSolver/>");
    ldl.solve(matrix, b, x[count - 1]);
  }
  setThreads(1);
  ASSERT_GT(x[0].count(), 0);
  EXPECT_EQ(std::memcmp(x[0].rows().data, x[1].rows().data, x[0].rows().doubles() * sizeof(double)), 0);
}

/// OpenBLAS takes 128 MB of address space at its first call, and would ask for ever.
TEST(SparseLDLSolverDeathTest, WithoutRoomForTheBlasItSaysSo) {
  testing::FLAGS_gtest_death_test_style = "threadsafe";  // a process of its own: nothing has called the BLAS before
  StoredMatrix matrix = randomMatrix(40, 3, 0.5, 1);
  const Vector b = randomVector(40, 1);
  SolverInScene ldl("<SparseLDLSolver/>");
  Vector x(40);
  const auto solveInSixtyMegabytes = [&] {
    long pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    const rlim_t most = rlim_t(pages) * rlim_t(sysconf(_SC_PAGESIZE)) + (60u << 20);
    const rlimit limit{most, most};
    setrlimit(RLIMIT_AS, &limit);
    alarm(600);  // of waiting for ever
    try {
      ldl.solve(matrix, b, x);
    } catch (const std::exception& error) {
      std::fprintf(stderr, "%s\n", error.what());
      std::_Exit(3);
    }
    std::_Exit(0);
  };
  EXPECT_EXIT(solveInSixtyMegabytes(), testing::ExitedWithCode(3), "128 MB for each thread: out of memory");
}
