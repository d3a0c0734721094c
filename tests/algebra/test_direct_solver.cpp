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
  void analyse(const BlockMatrix&) override {}
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

TEST(DirectSolver, RefinesASolveOnce) {
  for (const double error : {1e-2, 1e-4, 1.1e-10}) {
    const Solved solved = solveWith(error);
    EXPECT_EQ(solved.applications, 2) << error;
    EXPECT_NEAR(solved.residual, error * error, 1e-13) << error;
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

/// Refined, a factor that is wrong by 0.3 leaves 0.09, and one wrong by 0.33 more than the tenth that is asked for.
TEST(DirectSolver, AFactorWithoutARightDigitSaysSo) {
  EXPECT_EQ(solveWith(0.3).report.stop, SolveStop::converged);
  EXPECT_EQ(solveWith(0.33).report.stop, SolveStop::breakdown);
}
