// SPDX-License-Identifier: LGPL-2.1-or-later
// Factors in single precision: solutions as exact as in double, whatever the matrix; the same bits on any number of threads and
// after a restart; and no allocation from the second matrix of a pattern on.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "framework/algebra/direct_solver.h"
#include "framework/algebra/parallel.h"
#include "framework/scene/archive.h"
#include "tests/support/counted_allocations.h"
#include "tests/support/solver_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

const char* const single_precision = "<SparseLDLSolver precision=\"single\"/>";
const char* const double_precision = "<SparseLDLSolver precision=\"double\"/>";

/// A grid of l x m x n nodes with springs between neighbours, also along the diagonals, on a ground at one end. `stiffness` of
/// the nodes in the middle third of the cross-section, of the others 1.
StoredMatrix lattice(int l, int m, int n, double core = 1, double ground = 1) {
  const auto at = [&](int i, int j, int k) { return Index((i * m + j) * n + k); };
  BlockPattern pattern(Index(l) * m * n);
  std::vector<std::pair<Index, Mat3>> diagonal;
  struct Spring {
    Index a, b;
    Mat3 stiffness;
  };
  std::vector<Spring> springs;
  const auto isCore = [&](int j, int k) { return 3 * j >= m && 3 * j < 2 * m && 3 * k >= n && 3 * k < 2 * n; };
  for (int i = 0; i < l; ++i)
    for (int j = 0; j < m; ++j)
      for (int k = 0; k < n; ++k)
        for (int step = 14; step < 27; ++step) {  // the half of the neighbours that comes later
          const int a = i + step / 9 - 1, b = j + step / 3 % 3 - 1, c = k + step % 3 - 1;
          if (a >= l || b < 0 || b >= m || c < 0 || c >= n) continue;
          const Vec3 way = Vec3(step / 9 - 1, step / 3 % 3 - 1, step % 3 - 1).normalized();
          const Index pair[] = {at(i, j, k), at(a, b, c)};
          pattern.addClique(pair, 2);
          springs.push_back({pair[0], pair[1], (isCore(j, k) && isCore(b, c) ? core : 1.0) * way * way.transpose()});
        }
  BlockMatrix matrix(std::move(pattern));
  for (const Spring& spring : springs) {
    for (const Index end : {spring.a, spring.b}) matrix.add(end, end, spring.stiffness);
    matrix.add(spring.a, spring.b, -spring.stiffness), matrix.add(spring.b, spring.a, -spring.stiffness);
  }
  for (int j = 0; j < m; ++j)
    for (int k = 0; k < n; ++k) matrix.add(at(0, j, k), at(0, j, k), ground * Mat3::Identity());
  return StoredMatrix(std::move(matrix));
}

std::string told(const SolverInScene& solver, const char* attribute) {
  return solver.solver->data().find(attribute)->print();
}

bool sameBits(const Vector& a, const Vector& b) {
  return a.count() == b.count() && std::memcmp(a.rows().data, b.rows().data, a.rows().doubles() * sizeof(double)) == 0;
}

/// |x - y| in the norm of A's energy, as a part of y.
double errorOfEnergy(const BlockMatrix& a, const Vector& x, const Vector& y) {
  Vector difference(x.count()), product(x.count());
  copy(x, difference);
  axpy(-1, y, difference);
  a.multiply(difference, product);
  const double error = dot(difference, product);
  a.multiply(y, product);
  return std::sqrt(std::max(0.0, error) / dot(y, product));
}

/// y, corrected by residuals in extended precision, which leaves no more of its error than round-off.
Vector exactSolution(StoredMatrix& matrix, const Vector& b) {
  SolverInScene solver(double_precision);
  Vector y, correction, residual(b.count());
  solver.solve(matrix, b, y);
  const BlockMatrix& a = matrix.values;
  for (int k = 0; k < 4; ++k) {
    for (Index i = 0; i < a.rows(); ++i)
      for (int r = 0; r < 3; ++r) {
        long double sum = b[i][r];
        for (Index s = a.rowStart()[i]; s < a.rowStart()[i + 1]; ++s)
          for (int c = 0; c < 3; ++c)
            sum -= static_cast<long double>(a.values()[std::size_t(9 * s + 3 * r + c)]) * y[a.columns()[s]][c];
        residual[i][r] = double(sum);
      }
    solver.solve(matrix, residual, correction);
    axpy(1, correction, y);
  }
  return y;
}

TEST(FactorPrecision, SingleIsAsExactAsDouble) {
  struct Case {
    const char* name;
    StoredMatrix matrix;
  };
  Case cases[] = {{"cube", lattice(6, 6, 6)},
                  {"contrast of 1e4", lattice(7, 7, 7, 1e4)},
                  {"contrast of 1e8", lattice(7, 7, 7, 1e8)},
                  {"beam 20:1", lattice(60, 3, 3)},
                  {"on a ground a million times as stiff", lattice(6, 6, 6, 1, 1e6)},
                  {"without order", randomMatrix(80, 3, 0.05, 2)}};
  for (Case& each : cases) {
    SCOPED_TRACE(each.name);
    const Vector b = randomVector(each.matrix.rows(), 1);
    const Vector exact = exactSolution(each.matrix, b);
    SolverInScene in_single(single_precision), in_double(double_precision);
    Vector x, y;
    const SolveReport report = in_single.solve(each.matrix, b, x), other = in_double.solve(each.matrix, b, y);
    EXPECT_EQ(report.stop, SolveStop::converged);
    EXPECT_EQ(other.stop, SolveStop::converged);
    EXPECT_LT(report.relative_residual, std::max(1e-10, 3 * other.relative_residual));
    EXPECT_LT(errorOfEnergy(each.matrix.values, x, exact), std::max(2e-11, 3 * errorOfEnergy(each.matrix.values, y, exact)));
    EXPECT_EQ(told(in_double, "factorPrecision"), "double");
    fmt::print("{}: {} applications\n", each.name, told(in_single, "applications"));
  }
}

/// It is in fact single precision that was tested above.
TEST(FactorPrecision, TellsWhichOneItTook) {
  StoredMatrix matrix = lattice(6, 6, 6);
  const Vector b = randomVector(matrix.rows(), 1);
  SolverInScene in_single(single_precision), automatic("<SparseLDLSolver/>");
  EXPECT_EQ(told(automatic, "factorPrecision"), "single where one takes more than 5e7 operations, refined in double");
  Vector x;
  in_single.solve(matrix, b, x);
  EXPECT_EQ(told(in_single, "factorPrecision"), "single, refined in double");
  EXPECT_GE(std::stod(told(in_single, "applications")), 2);
  EXPECT_LE(std::stod(told(in_single, "applications")), 4);
  EXPECT_EQ(told(in_single, "precisionChanges"), "0");
  automatic.solve(matrix, b, x);
  EXPECT_EQ(told(automatic, "factorPrecision"), "double") << "216 nodes are few";
  StoredMatrix large = lattice(12, 12, 12);
  automatic.solve(large, randomVector(large.rows(), 1), x);
  EXPECT_EQ(told(automatic, "factorPrecision"), "single, refined in double");
}

/// What is too ill-conditioned has the bits of factors in double precision: where iterations do not converge, and where a pivot
/// is not positive in single precision. Beams that are hardly held.
TEST(FactorPrecision, WhatDoesNotConvergeIsFactoredInDouble) {
  for (const double ground : {1e-4, 1e-6}) {
    StoredMatrix matrix = lattice(40, 2, 2, 1, ground);
    const Vector b = randomVector(matrix.rows(), 1);
    SolverInScene in_single(single_precision), in_double(double_precision);
    Vector x, y;
    const SolveReport report = in_single.solve(matrix, b, x), other = in_double.solve(matrix, b, y);
    EXPECT_EQ(other.stop, SolveStop::converged) << ground;
    EXPECT_EQ(report.stop, SolveStop::converged) << ground;
    EXPECT_EQ(told(in_single, "factorPrecision"), "double") << ground;
    EXPECT_EQ(told(in_single, "precisionChanges"), "1") << ground;
    EXPECT_EQ(std::stod(told(in_single, "applications")) > 0, ground == 1e-4);
    EXPECT_TRUE(sameBits(x, y)) << ground;
    // the next 31 matrices too, and the one after them is tried again
    for (int k = 0; k < 32; ++k) {
      for (Index i = 0; i < matrix.rows(); ++i) matrix.values.add(i, i, Mat3::Identity());
      ++matrix.revision_number;
      EXPECT_EQ(in_single.solve(matrix, b, x).stop, SolveStop::converged);
      EXPECT_EQ(told(in_single, "factorPrecision"), k < 31 ? "double" : "single, refined in double") << ground << ", matrix " << k;
    }
  }
}

/// Each try is known for lost after few applications, and the next one waits twice as long: of 100 matrices three are tried.
TEST(FactorPrecision, WhatNeverConvergesIsTriedSeldom) {
  for (const double ground : {1e-4, 1e-6}) {
    StoredMatrix matrix = lattice(40, 2, 2, 1, ground);
    const Vector b = randomVector(matrix.rows(), 1);
    SolverInScene solver(single_precision);
    Vector x;
    for (int k = 0; k < 100; ++k) {
      matrix.values.add(0, 0, 1e-3 * ground * Mat3::Identity());
      ++matrix.revision_number;
      EXPECT_EQ(solver.solve(matrix, b, x).stop, SolveStop::converged);
    }
    EXPECT_EQ(told(solver, "precisionChanges"), "3") << ground;
    EXPECT_LE(std::stod(told(solver, "applications")), 5) << ground;
  }
}

/// Whose factors are made for somebody who keeps them, as those of former matrices are, before a solve asks for them: what one
/// matrix could not bear is forgotten like anywhere else.
TEST(FactorPrecision, MatricesThatWereFactoredBeforeTheirSolvesAreTriedAgain) {
  StoredMatrix matrix = lattice(40, 2, 2, 1, 1e-4);
  const Vector b = randomVector(matrix.rows(), 1);
  SolverInScene solver(single_precision);
  auto& direct = dynamic_cast<DirectSolver&>(*solver.solver);
  Vector x;
  for (int k = 0; k < 34; ++k) {
    SolveReport report;
    ASSERT_TRUE(direct.factor(matrix, report, {}));
    EXPECT_EQ(solver.solve(matrix, b, x).stop, SolveStop::converged);
    EXPECT_EQ(told(solver, "factorPrecision"), k < 32 ? "double" : "single, refined in double") << "matrix " << k;
    for (Index i = 0; i < matrix.rows(); ++i) matrix.values.add(i, i, Mat3::Identity());
    ++matrix.revision_number;
  }
}

/// A pivot that is negative by a little is seen in double precision alone, and no solution comes of it.
TEST(FactorPrecision, RefusesWhatDoubleRefuses) {
  for (const double least : {-1.0, -1e-3, -1e-6, -1e-9, -1e-11}) {
    StoredMatrix matrix = lattice(5, 5, 5);
    const Spectrum of = spectrum(matrix.dense());
    // the softest motion gets the energy `least` of the stiffest one
    const Eigen::VectorXd mode = of.vectors.col(0);
    const double change = least * of.values.tail(1)[0] - of.values[0];
    BlockPattern pattern(matrix.rows());
    for (Index i = 0; i < matrix.rows(); ++i)
      for (Index j = 0; j < matrix.rows(); ++j) pattern.addBlock(i, j);
    BlockMatrix whole(std::move(pattern));
    for (Index i = 0; i < matrix.rows(); ++i)
      for (Index j = 0; j < matrix.rows(); ++j) {
        const Index slot = matrix.values.slot(i, j);
        if (slot >= 0)
          for (int c = 0; c < 9; ++c)
            whole.values()[std::size_t(9 * whole.slot(i, j) + c)] += matrix.values.values()[std::size_t(9 * slot + c)];
        whole.add(i, j, Mat3(change * mode.segment<3>(3 * i) * mode.segment<3>(3 * j).transpose()));
      }
    StoredMatrix indefinite(std::move(whole));
    const Vector b = randomVector(matrix.rows(), 1);
    SolverInScene in_single(single_precision), in_double(double_precision);
    Vector x, y;
    const SolveReport report = in_single.solve(indefinite, b, x), other = in_double.solve(indefinite, b, y);
    EXPECT_EQ(other.stop, SolveStop::not_definite) << least;
    EXPECT_EQ(report.stop, SolveStop::not_definite) << least;
    EXPECT_FALSE(report.usable());
    if (least < -1e-4) {
      EXPECT_EQ(report.row, other.row) << least;
    }
    // and the next matrix, which is definite, is solved
    for (Index i = 0; i < indefinite.rows(); ++i) indefinite.values.add(i, i, 2 * of.values.tail(1)[0] * Mat3::Identity());
    ++indefinite.revision_number;
    EXPECT_EQ(in_single.solve(indefinite, b, x).stop, SolveStop::converged);
  }
}

/// 3,375 nodes: subtrees at once, and large supernodes in pieces.
TEST(FactorPrecision, TheBitsDoNotDependOnTheNumberOfThreads) {
  StoredMatrix matrix = lattice(15, 15, 15);
  const Vector b = randomVector(matrix.rows(), 1);
  Vector x[4];
  for (const int count : {1, 2, 3, 4}) {
    setThreads(count);
    SolverInScene solver("<SparseLDLSolver/>");
    solver.solve(matrix, b, x[count - 1]);
    EXPECT_EQ(told(solver, "factorPrecision"), "single, refined in double");
  }
  setThreads(1);
  for (int count = 1; count < 4; ++count) EXPECT_TRUE(sameBits(x[count], x[0])) << count;
}

/// Many right sides: from some solve on, with factors in double precision. A restart and a step that is taken back know.
TEST(FactorPrecision, ManySystemsWithOneMatrixGetDouble) {
  StoredMatrix matrix = lattice(9, 9, 9);
  SolverInScene solver(single_precision);
  Vector x, kept, again;
  int solves = 0;
  while (told(solver, "factorPrecision") != "double" && solves < 4000) {
    solver.solver->keepFor(matrix);
    solver.solve(matrix, randomVector(matrix.rows(), unsigned(++solves)), x);
  }
  ASSERT_LT(solves, 4000);
  EXPECT_GT(solves, 4);
  const Vector b = randomVector(matrix.rows(), unsigned(solves));
  solver.solver->takeBackFor(matrix);
  Archive written;
  written.enter("solver");
  solver.solver->serializeFor(matrix, written);
  solver.solve(matrix, b, kept);
  EXPECT_TRUE(sameBits(kept, x)) << "the step that was taken back is the same again";
  SolverInScene later(single_precision);
  Archive reading = written.readable();
  reading.enter("solver");
  later.solver->serializeFor(matrix, reading);
  later.solve(matrix, b, again);
  EXPECT_TRUE(sameBits(again, x)) << "and so it is after a restart";
}

/// A matrix that is solved with so often that factors in double precision would have cost less: the next ones get these, but not
/// where single precision has saved more with the matrices before.
TEST(FactorPrecision, OneMatrixWithManySolvesIsNoReasonForDouble) {
  StoredMatrix matrix = lattice(9, 9, 9);
  Vector x;
  const auto change = [&] {
    for (double& value : matrix.values.values()) value *= 2;
    ++matrix.revision_number;
  };
  const auto solveOften = [&](SolverInScene& solver, int most) {
    int solves = 0;
    do solver.solve(matrix, randomVector(matrix.rows(), unsigned(++solves)), x);
    while (solves < most && told(solver, "factorPrecision") != "double");
    return solves;
  };
  SolverInScene first(single_precision);
  const int until_double = solveOften(first, 4000);
  ASSERT_LT(until_double, 4000);
  for (const int easy : {0, 10}) {
    SolverInScene solver(single_precision);
    for (int k = 0; k < easy; ++k) change(), solveOften(solver, 1);
    change();
    EXPECT_EQ(solveOften(solver, until_double - 1), until_double - 1);
    EXPECT_EQ(told(solver, "factorPrecision"), "single, refined in double");
    change();
    solveOften(solver, 1);
    EXPECT_EQ(told(solver, "factorPrecision"), easy == 0 ? "double" : "single, refined in double") << easy;
  }
}

#if defined(STROMA_COUNTS_ALLOCATIONS)
/// Memory that is allocated, in bytes.
double allocated() {
  const struct mallinfo2 all = mallinfo2();
  return double(all.uordblks) + double(all.hblkhd);
}

/// Numbers in one precision do not lie beside those in the other one: neither while matrices are factored in double precision,
/// nor when single precision is tried again.
TEST(FactorPrecision, NoMemoryOfBothPrecisions) {
  const auto change = [](StoredMatrix& matrix, double by) {
    for (Index i = 0; i < matrix.rows(); ++i) matrix.values.add(i, i, by * Mat3::Identity());
    ++matrix.revision_number;
  };
  StoredMatrix matrix = lattice(12, 12, 12, 1, 1e-8);
  const Vector b = randomVector(matrix.rows(), 1);
  Vector x(b.count());
  double in_double = 0;
  {
    const double before = allocated();
    SolverInScene solver(double_precision);
    solver.solve(matrix, b, x);
    in_double = allocated() - before;
  }
  const double before = allocated();
  SolverInScene solver(single_precision);
  solver.solve(matrix, b, x);
  EXPECT_EQ(told(solver, "precisionChanges"), "1");
  const double given_up = allocated() - before, numbers = 8 * std::stod(told(solver, "factorEntries"));
  fmt::print("numbers in double {:.3g} MB; a solver in double {:.3g}, one that gave up {:.3g}", numbers / 1e6, in_double / 1e6,
             given_up / 1e6);
  EXPECT_LT(given_up, in_double + 0.6 * numbers) << "a copy of the matrix, and no factor";
  for (int k = 0; k < 32; ++k) change(matrix, k == 0 ? 1 : 1e-3), solver.solve(matrix, b, x);
  EXPECT_EQ(told(solver, "factorPrecision"), "single, refined in double");
  const double again = allocated() - before;
  fmt::print(", tried again {:.3g}\n", again / 1e6);
  EXPECT_LT(again, in_double + 1.0 * numbers);
}

TEST(FactorPrecision, AllocatesNothingForTheNextMatrixOfAPattern) {
  StoredMatrix matrix = lattice(9, 9, 9);
  const Vector b = randomVector(matrix.rows(), 1);
  SolverInScene solver(single_precision);
  Vector x;
  for (int i = 0; i < 2; ++i) ++matrix.revision_number, solver.solve(matrix, b, x);
  const long before = allocations;
  EXPECT_GT(before, 0) << "the counter counts";
  for (int i = 0; i < 3; ++i) {
    matrix.values.add(0, 0, Mat3::Identity());
    ++matrix.revision_number;
    EXPECT_EQ(solver.solve(matrix, b, x).stop, SolveStop::converged);
  }
  EXPECT_EQ(allocations, before);
}

/// METIS takes its memory in many pieces: half of all.
TEST(FactorPrecision, AnotherMatrixOfTheSamePatternTakesItsOrder) {
  StoredMatrix first = lattice(12, 12, 14), second = lattice(12, 12, 14), other = lattice(14, 12, 12);
  const Vector b = randomVector(first.rows(), 1);
  SolverInScene solver("<SparseLDLSolver/>"), alone("<SparseLDLSolver/>");
  Vector x, same;
  const auto takenBy = [&](StoredMatrix& matrix) {
    const long before = allocations;
    EXPECT_EQ(solver.solve(matrix, b, x).stop, SolveStop::converged);
    return allocations - before;
  };
  const long taken = takenBy(first);
  EXPECT_LT(3 * takenBy(second), 2 * taken);
  EXPECT_EQ(alone.solve(second, b, same).stop, SolveStop::converged);
  EXPECT_EQ(std::memcmp(x.rows().data, same.rows().data, x.rows().doubles() * sizeof(double)), 0);
  EXPECT_GT(3 * takenBy(other), 2 * taken) << "which has an order of its own";
}

/// A force field that takes another tangent has its pattern made anew, and mostly the same one comes out.
TEST(FactorPrecision, APatternThatIsMadeAnewAndIsTheSameIsNotAnalysed) {
  for (const char* precision : {"single", "double"}) {
    StoredMatrix matrix = lattice(8, 8, 8);
    const Vector b = randomVector(matrix.rows(), 1);
    SolverInScene solver(fmt::format("<SparseLDLSolver precision='{}'/>", precision).c_str());
    Vector x;
    const auto taken = [&] {
      const long before = allocations;
      EXPECT_EQ(solver.solve(matrix, b, x).stop, SolveStop::converged);
      return allocations - before;
    };
    const long with_analysis = taken();
    ++matrix.revision_number;
    const long again = taken();
    ++matrix.revision_number, ++matrix.pattern_number;
    EXPECT_LE(taken(), again + 5) << precision << " of " << with_analysis;
    EXPECT_GT(with_analysis, again + 50);
  }
}
#endif

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
