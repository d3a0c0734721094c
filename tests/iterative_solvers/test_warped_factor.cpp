// SPDX-License-Identifier: LGPL-2.1-or-later
// When WarpedFactor renews its factors and in what precision it applies them: with a direct solver that only counts.
#include <gtest/gtest.h>

#include "components/iterative_solvers/warped_factor.h"
#include "framework/scene/archive.h"
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

/// It remembers how often it has solved with each matrix.
class CountingSolver final : public DirectSolver {
 public:
  mutable Applied applied;
  int solves = 0;  ///< with the last matrix
  bool needsSymmetric() const override { return true; }
  SolveReport solveAll(SystemMatrix& matrix, std::span<const ConstRows> b, std::span<const Rows> x, const SolveTerms& terms) override {
    solves = ++remembered_.of(matrix).solves;
    return DirectSolver::solveAll(matrix, b, x, terms);
  }
  void serializeFor(SystemMatrix& matrix, Archive& archive) override { archive.value("solves", remembered_.of(matrix).solves); }
  void keepFor(SystemMatrix& matrix) override { remembered_.of(matrix).kept = remembered_.of(matrix).solves; }
  void takeBackFor(SystemMatrix& matrix) override { remembered_.of(matrix).solves = remembered_.of(matrix).kept; }

 protected:
  std::unique_ptr<Factorisation> makeFactorisation(bool) const override { return std::make_unique<CountingFactors>(applied); }

 private:
  struct Remembered {
    int solves = 0, kept = 0;
  };
  PerMatrix<Remembered> remembered_;
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

/// Fresh factors go on where former ones were given up: what those gained is not theirs. Else double precision, which helps here, would
/// seem to help nothing.
TEST(WarpedFactor, DecadesOfGivenUpSolvesAreNotCountedTwice) {
  Followed each;
  each.solve(1, 1e-4);
  SolveReport report, given_up;
  ++each.matrix.revision_number;
  EXPECT_TRUE(each.warped.follow(each.matrix, report, {}));
  given_up.stop = SolveStop::iteration_limit, given_up.iterations = 12, given_up.relative_residual = 1e-3;
  each.warped.solved(given_up);
  EXPECT_TRUE(each.warped.giveUp());
  EXPECT_TRUE(each.solve(25, 1e-6)) << "25 iterations for three decades";
  EXPECT_FALSE(each.isRough());
  each.warped.factorNext();
  EXPECT_TRUE(each.solve(20, 1e-4)) << "20 for four";
  EXPECT_FALSE(each.isRough());
}

/// What its solver remembers of the matrix that was factored, as the precision that served, is that of a run: it goes on after a
/// restart, beside what the solver remembers of the matrix itself, and is taken back with a step.
TEST(WarpedFactor, WhatItsSolverRemembersOfAFormerMatrixIsKept) {
  Followed first, later;
  const Vector b = randomVector(first.matrix.rows(), 1);
  Vector x(b.count());
  EXPECT_TRUE(first.solve(1, 1e-4));
  const auto solves = [&](Followed& each) {
    each.warped.solveFresh(b, x, {}, 1e-4);
    return each.solver.solves;
  };
  EXPECT_EQ(solves(first), 1);
  first.warped.keep(first.matrix);
  EXPECT_EQ(solves(first), 2);
  EXPECT_EQ(solves(first), 3);
  first.warped.takeBack(first.matrix);
  EXPECT_EQ(solves(first), 2) << "of a step that was taken back";
  Archive written;
  written.enter("solver");
  first.solver.serializeFor(first.matrix, written);
  first.warped.serialize(first.matrix, written);
  Archive reading = written.readable();
  reading.enter("solver");
  later.matrix.revision_number = first.matrix.revision_number;
  later.solver.serializeFor(later.matrix, reading);
  later.warped.serialize(later.matrix, reading);
  reading.checkAllRead();
  SolveReport report;
  EXPECT_TRUE(later.warped.follow(later.matrix, report, {}));
  EXPECT_EQ(solves(later), solves(first));
}

}  // namespace
}  // namespace stroma::test
