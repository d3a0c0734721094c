// SPDX-License-Identifier: LGPL-2.1-or-later
// A factorisation that is asked to stop gives no solution and leaves nothing behind: the next one has the bits of one that
// nobody stopped.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <thread>

#include "tests/support/solver_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// Those that look for themselves, and those whose library factors in one call.
const char* const solvers[] = {"SparseLDLSolver", "SparseLDLSolver precision=\"single\"", "EigenSparseLU", "EigenSimplicialLLT",
                               "CholeskySolver"};

std::string element(const char* type) { return std::string("<") + type + "/>"; }

bool sameBits(const Vector& a, const Vector& b) {
  return std::equal(a.rows().data, a.rows().data + a.rows().doubles(), b.rows().data);
}

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
    RecordProperty(std::string(type).substr(0, std::string(type).find(' ')) + "_stopped", stopped);
  }
}

/// A body whose analysis is made in a thread of its own, and left there.
TEST(StoppedFactorisation, WithinTheAnalysisOfALargeBodyItLeavesNothingBehind) {
  constexpr Index rows = 4100;
  StoredMatrix matrix = randomMatrix(rows, 1, 0.5, 1);
  const Vector b = randomVector(rows, 1);
  Vector expected;
  SolverInScene("<SparseLDLSolver/>").solve(matrix, b, expected);
  SolverInScene solver("<SparseLDLSolver/>");
  for (const int pause : {0, 5, 20, 60}) {
    SCOPED_TRACE(pause);
    ++matrix.pattern_number, ++matrix.revision_number;  // analysed anew
    StopRequest request;
    std::thread stopper([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(pause));
      request.make();
    });
    Vector x(rows);
    const SolveReport report = solver.solver->solve(matrix, b, x, {.stop = StopToken(request)});
    stopper.join();
    if (report.stop == SolveStop::stopped)
      EXPECT_EQ(norm(x), 0);
    else
      EXPECT_TRUE(sameBits(x, expected)) << describe(report.stop);
    Vector again;
    EXPECT_EQ(solver.solve(matrix, b, again).stop, SolveStop::converged);
    EXPECT_TRUE(sameBits(again, expected));
  }
}

/// Asks for the end of the work when it is assembled for the second time, which is when its factors are there.
class AskingMatrix final : public SystemMatrix {
 public:
  AskingMatrix(StoredMatrix& inner, StopRequest& request) : inner_(inner), request_(request) {}
  Index rows() const override { return inner_.rows(); }
  void multiply(ConstRows p, Rows out) const override { inner_.multiply(p, out); }
  const BlockMatrix& assemble() override {
    if (++assemblies_ == 2) request_.make();
    return inner_.assemble();
  }
  void diagonalBlocks(std::vector<double>& blocks) const override { inner_.diagonalBlocks(blocks); }
  MatrixKey key() const override { return inner_.key(); }
  bool symmetric() const override { return inner_.symmetric(); }
  bool prefersAssembled(int) const override { return true; }
  std::string describeRow(Index row) const override { return inner_.describeRow(row); }

 private:
  StoredMatrix& inner_;
  StopRequest& request_;
  int assemblies_ = 0;
};

/// Products with factors of the symmetric part get no further, and L U would take its time.
TEST(StoppedFactorisation, AStopIsHeededBeforeTheSecondFactorisationOfAnUnsymmetricMatrix) {
  StoredMatrix stored = randomMatrix(520, 2, 0.5, 1);
  for (Index i = 0; i < stored.rows(); ++i) {
    const double size = std::pow(10, 1 + double(i) / 130);  // eigenvalues all along a line
    stored.values.add(i, i, size * (Mat3() << 0, 1, 2, -1, 0, 3, -2, -3, 0).finished());
  }
  stored.is_symmetric = false;
  const Vector b = randomVector(520, 1);
  StopRequest request;
  AskingMatrix matrix(stored, request);
  SolverInScene solver("<SparseLDLSolver/>"), patient("<SparseLDLSolver/>");
  Vector x(520);
  const SolveReport report = solver.solver->solve(matrix, b, x, {.stop = StopToken(request)});
  EXPECT_EQ(report.stop, SolveStop::stopped) << describe(report.stop);
  EXPECT_EQ(norm(x), 0);
  EXPECT_EQ(patient.solve(stored, b, x).stop, SolveStop::converged);
  EXPECT_GT(norm(x), 0);
}

/// A stop is no word about the matrix, wherever it comes: not that it is not definite, nor that its solution is good.
TEST(StoppedFactorisation, AStopBetweenFactorsAndSolutionsIsToldAsOne) {
  for (const char* type : {"SparseLDLSolver precision=\"single\"", "SparseLDLSolver precision=\"double\"", "EigenSimplicialLLT"})
    for (const std::size_t sides : {1, 5}) {
      StoredMatrix stored = randomMatrix(40, 3, 0.5, 1);
      StopRequest request;
      AskingMatrix matrix(stored, request);
      SolverInScene solver(element(type));
      std::vector<Vector> b, x(sides);
      for (std::size_t i = 0; i < sides; ++i) b.push_back(randomVector(40, int(i) + 1)), x[i].resize(40);
      const std::vector<ConstRows> right(b.begin(), b.end());
      const std::vector<Rows> solutions(x.begin(), x.end());
      const SolveReport report = solver.solver->solveAll(matrix, right, solutions, {.stop = StopToken(request)});
      EXPECT_EQ(report.stop, SolveStop::stopped) << type << ": " << describe(report.stop);
      for (const Vector& each : x) EXPECT_EQ(norm(each), 0) << type;
    }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
