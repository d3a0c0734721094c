// SPDX-License-Identifier: LGPL-2.1-or-later
// PCGLinearSolver where a scene names no preconditioner: what it does where the way that it chose does not get there, and the same
// choices in a run that is taken up again.
#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <utility>

#include "framework/scene/archive.h"
#include "tests/iterative_solvers/automatic_problems.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// A cube of cells that lock: multigrid takes a seventh of the iterations of block Jacobi there, each at ten times the cost.
struct LockedCube {
  LockedCube() : matrix(made()), b(matrix.rows()) {
    for (Index i = 14 * 14; i < b.count(); ++i) b[i] = Vec3(0.1, 0, -1);
  }
  static StoredMatrix made() {
    ElasticBlock block;
    block.cells = {13, 13, 13};
    block.poisson = 0.4999;
    StoredMatrix matrix = block.matrix();
    for (Index k = 0; k < block.nodes(2); ++k)
      for (Index j = 0; j < block.nodes(1); ++j)
        for (Index i = 0; i < block.nodes(0); ++i) matrix.nodes.push_back(Vec3(i, j, k));
    return matrix;
  }
  int solve(SolverInScene& solver) {
    ++matrix.revision_number;
    Vector x(b.count());
    const SolveReport report = solver.solve(matrix, b, x);
    EXPECT_EQ(report.stop, SolveStop::converged) << describe(report.stop);
    return report.iterations;
  }
  StoredMatrix matrix;
  Vector b;
};

/// Newton's method meets such matrices, adds to their diagonal and goes on.
TEST(AutomaticPreconditioner, OneIndefiniteMatrixIsRefusedAndTheNextOneGoesTheFormerWay) {
  Needle needle;
  SolverInScene solver("<PCGLinearSolver/>");
  for (int step = 0; step < 8; ++step) EXPECT_EQ(needle.solve(solver).stop, SolveStop::converged);
  const std::string choice = choiceOf(solver), changes = changesOf(solver);
  EXPECT_TRUE(says(choice, "factors instead of iterations")) << choice;
  for (int round = 0; round < 5; ++round) {
    for (int k = 0; k < 8; ++k) {
      const SolveReport refused = needle.solve(solver, -0.01);
      EXPECT_EQ(refused.stop, SolveStop::not_definite) << describe(refused.stop);
      EXPECT_LE(refused.iterations, 1);
    }
    EXPECT_EQ(choiceOf(solver), choice);
    const SolveReport report = needle.solve(solver);
    EXPECT_EQ(report.stop, SolveStop::converged) << describe(report.stop);
    EXPECT_EQ(report.iterations, 1);
    EXPECT_EQ(changesOf(solver), changes);
  }
}

/// Counted in the checkpoint, and by a step that is taken back.
TEST(AutomaticPreconditioner, ManyRefusalsInARowBringBlockJacobiAndAreTold) {
  Needle needle;
  SolverInScene solver("<PCGLinearSolver/>"), later("<PCGLinearSolver/>");
  for (int step = 0; step < 8; ++step) needle.solve(solver);
  const auto refuse = [&](SolverInScene& of, int times) {
    for (int k = 0; k < times; ++k) needle.solve(of, -0.01);
  };
  refuse(solver, 10);
  solver.solver->keepFor(needle.matrix);
  Archive written;
  written.enter("solver");
  solver.solver->serializeFor(needle.matrix, written);
  refuse(solver, 9);
  solver.solver->takeBackFor(needle.matrix);
  refuse(solver, 9);
  EXPECT_TRUE(says(choiceOf(solver), "factors instead of iterations")) << choiceOf(solver);
  refuse(solver, 1);
  const std::string choice = choiceOf(solver);
  EXPECT_TRUE(says(choice, "block Jacobi: the matrix was not definite in 20 solves in a row")) << choice;
  Archive reading = written.readable();
  reading.enter("solver");
  later.solver->serializeFor(needle.matrix, reading);
  refuse(later, 9);
  EXPECT_TRUE(says(choiceOf(later), "factors instead of iterations")) << choiceOf(later);
  refuse(later, 1);
  EXPECT_EQ(choiceOf(later), choice);
  const SolveReport report = needle.solve(solver);
  EXPECT_GT(report.iterations, 100);
  EXPECT_EQ(choiceOf(solver), choice);
  solver.solver->reset();
  EXPECT_TRUE(says(choiceOf(solver), "block Jacobi, or by multigrid or factors once")) << choiceOf(solver);
}

/// What a direct solver leaves is worked off, or told.
TEST(AutomaticPreconditioner, ADirectSolveHeedsTheTolerance) {
  for (const char* tolerance : {"1e-11", "1e-12", "1e-13", "1e-15"}) {
    Needle needle;
    SolverInScene solver(std::string("<PCGLinearSolver tolerance='") + tolerance + "'/>");
    for (int step = 0; step < 8; ++step) {
      const SolveReport report = needle.solve(solver);
      EXPECT_LT(needle.residual, 1e-8);
      if (report.stop == SolveStop::converged)
        EXPECT_LE(needle.residual, 1.2 * std::stod(tolerance));
      else
        EXPECT_EQ(report.stop, SolveStop::stagnated) << describe(report.stop);
    }
    EXPECT_TRUE(says(choiceOf(solver), "factors instead of iterations")) << choiceOf(solver);
  }
}

/// Round-off is as far as any way comes: estimates stay numbers.
TEST(AutomaticPreconditioner, AToleranceOfZeroChangesToo) {
  Needle needle;
  SolverInScene solver("<PCGLinearSolver tolerance='0'/>");
  EXPECT_LT(needle.solve(solver).iterations, 5000);
  EXPECT_NE(changesOf(solver), "0");
}

/// The solver says so; also in a run that is taken up again.
TEST(AutomaticPreconditioner, MultigridThatDoesNotPayIsGivenUpForFactors) {
  LockedCube cube;
  SolverInScene solver("<PCGLinearSolver/>"), later("<PCGLinearSolver/>");
  SolverInScene named("<PCGLinearSolver preconditioner='block_jacobi'/>");
  const int plain = cube.solve(named);
  EXPECT_GT(plain, 320) << "block Jacobi is good enough here";
  for (int step = 0; step < 10; ++step) EXPECT_LT(cube.solve(solver), plain);
  EXPECT_TRUE(says(choiceOf(solver), "factors")) << choiceOf(solver);
  const int found = cube.solve(solver);
  EXPECT_LT(found, 20);
  Archive written;
  written.enter("solver");
  solver.solver->serializeFor(cube.matrix, written);
  Archive reading = written.readable();
  reading.enter("solver");
  later.solver->serializeFor(cube.matrix, reading);
  EXPECT_EQ(choiceOf(later), choiceOf(solver));
  EXPECT_EQ(changesOf(later), changesOf(solver));
  EXPECT_EQ(cube.solve(later), found);
}

/// As in a run that goes on: whatever that run has chosen when.
template <class Solver>
void expectTheSameWhereItIsTakenUpAndBack() {
  constexpr int steps = 10;
  const auto same = [](const Vector& a, const Vector& b) {
    return std::memcmp(a.rows().data, b.rows().data, a.rows().doubles() * sizeof(double)) == 0;
  };
  Beam beam(0);
  Solver whole("<PCGLinearSolver/>"), first("<PCGLinearSolver/>");
  std::vector<Vector> found;
  std::vector<std::string> choices;
  for (int step = 0; step < steps; ++step) {
    beam.solve(whole);
    found.push_back(std::move(beam.x));
    choices.push_back(choiceOf(whole));
  }
  for (int step = 0; step < steps; ++step) {
    first.solver->keepFor(beam.matrix);
    Archive written;
    written.enter("solver");
    first.solver->serializeFor(beam.matrix, written);
    beam.solve(first), beam.solve(first);
    first.solver->takeBackFor(beam.matrix);
    beam.solve(first);
    EXPECT_TRUE(same(beam.x, found[std::size_t(step)])) << "taken back, step " << step << ": " << choiceOf(first);
    EXPECT_EQ(choiceOf(first), choices[std::size_t(step)]);
    Solver second("<PCGLinearSolver/>");
    Archive reading = written.readable();
    reading.enter("solver");
    second.solver->serializeFor(beam.matrix, reading);
    beam.solve(second);
    EXPECT_TRUE(same(beam.x, found[std::size_t(step)])) << "taken up, step " << step << ": " << choiceOf(second);
    EXPECT_EQ(choiceOf(second), choices[std::size_t(step)]);
  }
}

TEST(AutomaticPreconditioner, AChoiceIsTakenUpAgainAndTakenBack) {
  expectTheSameWhereItIsTakenUpAndBack<SolverInScene>();
  expectTheSameWhereItIsTakenUpAndBack<SolverWhereMatricesVary>();
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
