// SPDX-License-Identifier: LGPL-2.1-or-later
// When WarpedFactor renews its factors and in what precision it applies them: with a direct solver that only counts.
#include <gtest/gtest.h>

#include "components/iterative_solvers/warped_factor.h"
#include "tests/iterative_solvers/block_problem.h"

namespace stroma::test {
namespace {

struct Applied {
  int exactly = 0, roughly = 0;
};

/// A factorisation costs as much as ten applications.
class CountingFactors final : public Factorisation {
 public:
  explicit CountingFactors(Applied& applied) : applied_(applied) {}
  bool analyse(const BlockMatrix&, StopToken) override { return true; }
  void load(const BlockMatrix&) override {}
  SolveStop factor(Index&, StopToken) override { return SolveStop::converged; }
  void apply(ConstRows b, Rows x) override { ++applied_.exactly, copy(b, x); }
  void applyRoughly(ConstRows b, Rows x) override { ++applied_.roughly, copy(b, x); }
  Cost cost() const override { return {10, 1}; }

 private:
  Applied& applied_;
};

class CountingSolver final : public DirectSolver {
 public:
  mutable Applied applied;
  bool needsSymmetric() const override { return true; }

 protected:
  std::unique_ptr<Factorisation> makeFactorisation(bool) const override { return std::make_unique<CountingFactors>(applied); }
};

struct Followed {
  StoredMatrix matrix = matrixOf(box(2, 2, 2));
  CountingSolver solver;
  WarpedFactor warped{solver};
  /// Of the next matrix; true when it was factored.
  bool solve(int iterations, double residual) {
    SolveReport report;
    ++matrix.revision_number;
    EXPECT_TRUE(warped.follow(matrix, report, {}));
    SolveReport solved;
    solved.iterations = iterations, solved.relative_residual = residual;
    warped.solved(solved);
    return report.factored;
  }
  bool isRough() {
    Vector r(matrix.rows()), z(matrix.rows());
    const int before = solver.applied.roughly;
    warped.apply(r, z);
    return solver.applied.roughly > before;
  }
};

/// Loose solves and others by turns: that a solve to four decades takes more than one to one decade is no reason for new factors. That
/// it takes more for a decade is.
TEST(WarpedFactor, SolvesAreComparedByTheirDecades) {
  Followed even, aged;
  for (Followed* each : {&even, &aged}) EXPECT_TRUE(each->solve(1, 0.1));
  for (int turn = 0; turn < 4; ++turn) {
    EXPECT_FALSE(even.solve(3, 0.1)) << turn;
    EXPECT_FALSE(even.solve(9, 1e-4)) << turn;
  }
  EXPECT_FALSE(aged.solve(3, 0.1));
  EXPECT_FALSE(aged.solve(20, 1e-4));
  EXPECT_TRUE(aged.solve(3, 0.1));
}

/// Many iterations with factors of the very matrix have two reasons. Double precision helps where it is their precision, and is given up
/// where products have terms that no factors have.
TEST(WarpedFactor, DoublePrecisionIsKeptWhereItHelps) {
  for (const bool helps : {false, true}) {
    Followed each;
    each.solve(30, 1e-4);
    EXPECT_FALSE(each.isRough());
    each.warped.factorNext();
    EXPECT_TRUE(each.solve(helps ? 6 : 28, 1e-4));
    EXPECT_EQ(each.isRough(), !helps);
    each.warped.factorNext();
    each.solve(helps ? 6 : 30, 1e-4);
    EXPECT_EQ(each.isRough(), !helps) << "tried once";
  }
}

}  // namespace
}  // namespace stroma::test
