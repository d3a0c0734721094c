// SPDX-License-Identifier: LGPL-2.1-or-later
// Many right sides at once: what a right side becomes depends neither on those beside it nor on the number of threads, in both
// precisions; and many of them are worth factors in double.
#include <gtest/gtest.h>

#include <cstring>

#include "framework/algebra/parallel.h"
#include "tests/support/elastic_block.h"
#include "tests/support/solver_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

StoredMatrix blockOf(Index cells) {
  ElasticBlock block;
  block.cells = {cells, cells, cells};
  return block.matrix();
}

/// Each of two nodes, as a row of contact has.
std::vector<Vector> rightSides(Index rows, std::size_t count) {
  std::vector<Vector> sides(count);
  for (std::size_t i = 0; i < count; ++i) {
    sides[i].resize(rows);
    const Vector numbers = randomVector(2, unsigned(i));
    for (Index k = 0; k < 2; ++k) sides[i][(Index(7 * i) + 31 * k) % rows] += numbers[k];
  }
  return sides;
}

std::vector<Vector> solutions(LinearSolver& solver, StoredMatrix& matrix, const std::vector<Vector>& b, std::size_t first,
                              std::size_t count) {
  std::vector<Vector> x(count);
  std::vector<ConstRows> asked;
  std::vector<Rows> answers;
  for (std::size_t i = 0; i < count; ++i) {
    x[i].resize(matrix.rows());
    asked.push_back(b[first + i]), answers.push_back(x[i]);
  }
  const SolveReport report = solver.solveAll(matrix, asked, answers);
  EXPECT_EQ(report.stop, SolveStop::converged) << describe(report.stop);
  EXPECT_LT(report.relative_residual, 1e-10);
  return x;
}

bool sameBits(const Vector& a, const Vector& b) {
  return std::memcmp(a.rows().data, b.rows().data, a.rows().doubles() * sizeof(double)) == 0;
}

std::string told(const SolverInScene& solver, const char* attribute) { return solver.solver->data().find(attribute)->print(); }

TEST(RightSides, DoNotFeelEachOther) {
  StoredMatrix matrix = blockOf(6);
  const std::vector<Vector> b = rightSides(matrix.rows(), 41);
  for (const char* precision : {"single", "double"}) {
    SolverInScene solver("<SparseLDLSolver precision=\"" + std::string(precision) + "\"/>");
    const std::vector<Vector> all = solutions(*solver.solver, matrix, b, 0, 41);
    for (const std::size_t first : {std::size_t(0), std::size_t(13), std::size_t(36)}) {
      const std::vector<Vector> few = solutions(*solver.solver, matrix, b, first, 5);
      for (std::size_t i = 0; i < 5; ++i) EXPECT_TRUE(sameBits(few[i], all[first + i])) << precision << ", " << first + i;
    }
    setThreads(3);
    const std::vector<Vector> by_threads = solutions(*solver.solver, matrix, b, 0, 41);
    setThreads(1);
    for (std::size_t i = 0; i < 41; ++i) EXPECT_TRUE(sameBits(by_threads[i], all[i])) << precision << ", " << i;
    EXPECT_EQ(told(solver, "factorPrecision"), precision == std::string("double") ? "double" : "single, refined in double");
  }
}

/// A few hundred cost more iterations than factors in double precision do; the next matrices are factored in it at once.
TEST(RightSides, ManyAreWorthFactorsInDouble) {
  StoredMatrix matrix = blockOf(12);
  const std::vector<Vector> b = rightSides(matrix.rows(), 600);
  SolverInScene solver("<SparseLDLSolver/>");
  solutions(*solver.solver, matrix, b, 0, 5);
  EXPECT_EQ(told(solver, "factorPrecision"), "single, refined in double");
  solutions(*solver.solver, matrix, b, 0, b.size());
  EXPECT_EQ(told(solver, "factorPrecision"), "double");
  matrix.values.add(0, 0, Mat3::Identity());
  ++matrix.revision_number;
  solutions(*solver.solver, matrix, b, 0, 5);
  EXPECT_EQ(told(solver, "factorPrecision"), "double");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
