// SPDX-License-Identifier: LGPL-2.1-or-later
// A factorisation that is asked to stop gives no solution and leaves nothing behind: the next one has the bits of one that
// nobody stopped.
#include <gtest/gtest.h>

#include <random>
#include <thread>

#include "tests/support/solver_fixture.h"

using namespace stroma;
using namespace stroma::test;

namespace {

/// Those that look for themselves, and those whose library factors in one call.
const char* const solvers[] = {"SparseLDLSolver", "EigenSparseLU", "EigenSimplicialLLT", "CholeskySolver"};

std::string element(const char* type) { return std::string("<") + type + "/>"; }

bool sameBits(const Vector& a, const Vector& b) {
  return std::equal(a.rows().data, a.rows().data + a.rows().doubles(), b.rows().data);
}

}  // namespace

TEST(StoppedFactorisation, ARequestThatIsThereIsHeededBeforeTheWork) {
  for (const char* type : solvers) {
    StoredMatrix matrix = randomMatrix(40, 3, 0.5, 1);
    const Vector b = randomVector(40, 1);
    SolverInScene solver(element(type));
    Vector x(40);
    StopRequest request;
    request.make();
    const SolveReport report = solver.solver->solve(matrix, b, x, {.stop = StopToken(request)});
    EXPECT_EQ(report.stop, SolveStop::stopped) << type;
    EXPECT_FALSE(report.usable());
    EXPECT_FALSE(report.factored) << type;
    EXPECT_EQ(norm(x), 0) << type;
    request.take();
    EXPECT_EQ(solver.solver->solve(matrix, b, x, {.stop = StopToken(request)}).stop, SolveStop::converged) << type;
  }
}

TEST(StoppedFactorisation, AtAnyMomentItLeavesNothingBehind) {
  std::mt19937 random(3);
  for (const char* type : solvers) {
    StoredMatrix matrix = randomMatrix(520, 2, 0.5, 1);
    const Vector b = randomVector(520, 1);
    Vector expected;
    SolverInScene(element(type)).solve(matrix, b, expected);
    SolverInScene solver(element(type));
    int stopped = 0;
    for (int trial = 0; trial < 8; ++trial) {
      SCOPED_TRACE(fmt::format("{} {}", type, trial));
      ++matrix.revision_number;  // factored anew
      StopRequest request;
      const auto pause = std::chrono::microseconds(std::uniform_int_distribution<int>(0, 20000)(random));
      std::thread stopper([&] {
        std::this_thread::sleep_for(pause);
        request.make();
      });
      Vector x(520);
      const SolveReport report = solver.solver->solve(matrix, b, x, {.stop = StopToken(request)});
      stopper.join();
      if (report.stop == SolveStop::stopped) {
        ++stopped;
        EXPECT_EQ(norm(x), 0);
      } else {
        EXPECT_EQ(report.stop, SolveStop::converged);
        EXPECT_TRUE(sameBits(x, expected));
      }
      Vector again;
      EXPECT_EQ(solver.solve(matrix, b, again).stop, SolveStop::converged);
      EXPECT_TRUE(sameBits(again, expected));
    }
    RecordProperty(std::string(type) + "_stopped", stopped);
  }
}
