// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/algebra/direct_solver.h"

#include <gtest/gtest.h>

#include "tests/support/stored_matrix.h"

using namespace stroma;
using namespace stroma::test;

namespace {

/// A dense inverse that is wrong by a known share: x = (1 + error) A^-1 b. One refinement leaves error^2 of x.
class WrongInverse final : public Factorisation {
 public:
  WrongInverse(double error, int& applications) : error_(error), applications_(applications) {}
  bool analyse(const BlockMatrix&, StopToken) override { return true; }
  void load(const BlockMatrix& matrix) override { factors_.compute(StoredMatrix(matrix).dense()); }
  SolveStop factor(Index&, StopToken) override { return SolveStop::converged; }
  void apply(ConstRows b, Rows x) override {
    ++applications_;
    const Eigen::VectorXd solution = (1 + error_) * factors_.solve(dense(b));
    for (Index i = 0; i < x.count; ++i) x[i] = Vec3(solution.segment<3>(3 * i));
  }
  Cost cost() const override { return {}; }

 private:
  double error_;
  int& applications_;
  Eigen::LDLT<Eigen::MatrixXd> factors_;
};

class WrongSolver final : public DirectSolver {
 public:
  explicit WrongSolver(double error) : error_(error) {}
  bool needsSymmetric() const override { return true; }
  mutable int applications = 0;

 protected:
  std::unique_ptr<Factorisation> makeFactorisation(bool) const override {
    return std::make_unique<WrongInverse>(error_, applications);
  }

 private:
  double error_;
};

struct Solved {
  SolveReport report;
  double residual;  ///< |b - A x| / |b|
  int applications;
};

Solved solveWith(double error) {
  StoredMatrix matrix = randomMatrix(20, 3, 0.5, 1);
  const Vector b = randomVector(20, 1);
  Vector x(20);
  WrongSolver solver(error);
  const SolveReport report = solver.solve(matrix, b, x, {});
  return {report, (dense(b) - matrix.dense() * dense(x)).norm() / dense(b).norm(), solver.applications};
}

}  // namespace

TEST(DirectSolver, RefinesASolveUntilItIsGood) {
  const struct {
    double error, left;  ///< of the factor, and the power of it that the last refinement leaves
    int applications;
  } cases[] = {{1.1e-10, 2, 2}, {9e-5, 2, 2}, {5e-3, 4, 4}, {0.05, 7, 7}};
  for (const auto& one : cases) {
    const Solved solved = solveWith(one.error);
    EXPECT_EQ(solved.applications, one.applications) << one.error;
    EXPECT_NEAR(solved.residual, std::pow(one.error, one.left), 1e-13 + 1e-6 * solved.residual) << one.error;
    EXPECT_NEAR(solved.report.relative_residual, solved.residual, 1e-13) << "of what it returns";
    EXPECT_EQ(solved.report.stop, SolveStop::converged);
  }
}

TEST(DirectSolver, LeavesAGoodSolveAsItIs) {
  const Solved solved = solveWith(0.9e-10);
  EXPECT_EQ(solved.applications, 1);
  EXPECT_NEAR(solved.residual, 0.9e-10, 1e-13);
  EXPECT_NEAR(solved.report.relative_residual, solved.residual, 1e-13);
}

/// A factor that is wrong by 0.2 leaves 0.2^9 = 5e-7 after eight refinements, and one wrong by 0.4 leaves 0.4^9 = 2.6e-4,
/// more than the 1e-5 that a person is told of. One that is wrong by 0.6 does not halve the residual: 0.36 is left.
TEST(DirectSolver, AFactorThatLosesDigitsSaysSo) {
  EXPECT_EQ(solveWith(0.2).report.stop, SolveStop::converged);
  EXPECT_EQ(solveWith(0.2).applications, 9);
  EXPECT_EQ(solveWith(0.4).report.stop, SolveStop::stagnated);
  EXPECT_NEAR(solveWith(0.4).residual, std::pow(0.4, 9), 1e-10);
  EXPECT_EQ(solveWith(0.6).report.stop, SolveStop::breakdown);
}

/// A refinement that makes it worse is taken back.
TEST(DirectSolver, KeepsTheBetterOfTwoSolves) { EXPECT_NEAR(solveWith(1.5).report.relative_residual, 1.5, 1e-13); }
