// SPDX-License-Identifier: LGPL-2.1-or-later
// PCGLinearSolver where a scene names no preconditioner: block Jacobi as long as its iterations are few, multigrid when they
// are not, and the same choices in a run that was taken up again.
#include <gtest/gtest.h>

#include <cstring>
#include <utility>

#include "framework/scene/archive.h"
#include "tests/support/elastic_block.h"
#include "tests/support/solver_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// A beam of 3,479 nodes along z; `density` as the mass of an implicit step.
struct Beam {
  explicit Beam(double density) : matrix(made(density)), b(matrix.rows()) {
    for (Index i = 49; i < b.count(); ++i) b[i] = Vec3(0.1, 0, -1);
  }
  static StoredMatrix made(double density) {
    ElasticBlock block;
    block.cells = {6, 6, 70};
    block.density = density;
    StoredMatrix matrix = block.matrix();
    matrix.nodes.resize(std::size_t(matrix.rows()));
    for (Index k = 0; k < block.nodes(2); ++k)
      for (Index j = 0; j < block.nodes(1); ++j)
        for (Index i = 0; i < block.nodes(0); ++i) matrix.nodes[std::size_t(block.node(i, j, k))] = Vec3(i, j, k);
    return matrix;
  }
  /// Iterations of the next step's solve: the values may have changed.
  int solve(SolverInScene& solver) {
    ++matrix.revision_number;
    x = Vector(b.count());
    const SolveReport report = solver.solve(matrix, b, x);
    EXPECT_EQ(report.stop, SolveStop::converged) << describe(report.stop);
    Vector r(b.count());
    matrix.values.multiply(x, r);
    EXPECT_LE(distance(r, b), 1.2e-8 * norm(b));
    return report.iterations;
  }
  StoredMatrix matrix;
  Vector b, x;
};

std::string choiceOf(const SolverInScene& solver) { return solver.solver->data().find("choice")->print(); }
std::string changesOf(const SolverInScene& solver) { return solver.solver->data().find("changes")->print(); }
bool says(const std::string& text, const std::string& words) { return text.find(words) != std::string::npos; }

TEST(AutomaticPreconditioner, ManyIterationsBringMultigrid) {
  Beam beam(0);
  SolverInScene solver("<PCGLinearSolver/>");
  EXPECT_TRUE(says(choiceOf(solver), "block Jacobi, or by multigrid")) << choiceOf(solver);
  const int first = beam.solve(solver);
  EXPECT_GT(first, 320) << "block Jacobi is good enough here";
  const int second = beam.solve(solver);
  EXPECT_LT(second, 30);
  EXPECT_EQ(changesOf(solver), "1");
  EXPECT_TRUE(says(choiceOf(solver), "by multigrid: block Jacobi took")) << choiceOf(solver);
  for (int step = 0; step < 5; ++step) EXPECT_LT(beam.solve(solver), 30);
  EXPECT_EQ(changesOf(solver), "1");
}

TEST(AutomaticPreconditioner, AMassThatKeepsIterationsFewKeepsBlockJacobi) {
  Beam beam(0.5);
  SolverInScene solver("<PCGLinearSolver/>"), named("<PCGLinearSolver preconditioner='block_jacobi'/>");
  for (int step = 0; step < 10; ++step) {
    const int found = beam.solve(solver);
    const Vector own = std::move(beam.x);
    EXPECT_LT(found, 160);
    EXPECT_EQ(beam.solve(named), found);
    EXPECT_EQ(std::memcmp(own.rows().data, beam.x.rows().data, own.rows().doubles() * sizeof(double)), 0);
  }
  EXPECT_EQ(changesOf(solver), "0");
  EXPECT_EQ(beam.matrix.assemblies, 0);
}

/// The same body with products that cost four times as much, as those of hyperelastic hexahedra: a V-cycle is then worth more
/// iterations of block Jacobi.
TEST(AutomaticPreconditioner, DearProductsBringMultigridEarlier) {
  Beam cheap(0.02), dear(0.02);
  cheap.matrix.product_nanoseconds = 25. * cheap.matrix.rows();
  dear.matrix.product_nanoseconds = 100. * dear.matrix.rows();
  SolverInScene plain("<PCGLinearSolver/>"), solver("<PCGLinearSolver/>");
  const int many = dear.solve(solver);
  EXPECT_GT(many, 80);
  EXPECT_LT(many, 160);
  int steps = 1, found = many;
  for (; steps < 10 && changesOf(solver) == "0"; ++steps) found = dear.solve(solver);
  EXPECT_EQ(changesOf(solver), "1") << steps << " steps of " << many << " iterations";
  EXPECT_LT(found, 20);
  for (int step = 0; step < steps; ++step) EXPECT_EQ(cheap.solve(plain), many);
  EXPECT_EQ(changesOf(plain), "0");
}

/// Who caps iterations, or wants no matrix, has said what a step may cost.
TEST(AutomaticPreconditioner, WhatTheSceneSaysStays) {
  for (const char* attributes : {"iterations='3000'", "template='GraphScattered'"}) {
    Beam beam(0);
    SolverInScene solver(std::string("<PCGLinearSolver tolerance='1e-8' ") + attributes + "/>");
    for (int step = 0; step < 3; ++step) EXPECT_GT(beam.solve(solver), 320);
    EXPECT_EQ(changesOf(solver), "0");
    EXPECT_EQ(beam.matrix.assemblies, 0);
    EXPECT_TRUE(says(choiceOf(solver), "caps iterations or wants no matrix")) << choiceOf(solver);
  }
}

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

/// It goes back, once, and says so; also a run that is taken up again.
TEST(AutomaticPreconditioner, MultigridThatDoesNotPayIsGivenUp) {
  LockedCube cube;
  SolverInScene solver("<PCGLinearSolver/>"), later("<PCGLinearSolver/>");
  const int plain = cube.solve(solver);
  EXPECT_GT(plain, 320) << "block Jacobi is good enough here";
  EXPECT_EQ(changesOf(solver), "0");
  int with_multigrid = 0, steps = 0;
  for (; steps < 8 && changesOf(solver) != "2"; ++steps) {
    const int found = cube.solve(solver);
    if (changesOf(solver) == "1") with_multigrid = found;
  }
  ASSERT_EQ(changesOf(solver), "2") << steps << " steps";
  EXPECT_GT(with_multigrid, 0);
  EXPECT_GT(10 * with_multigrid, plain) << "multigrid is the better choice here";
  EXPECT_TRUE(says(choiceOf(solver), "by block Jacobi: multigrid took")) << choiceOf(solver);
  for (int step = 0; step < 5; ++step) EXPECT_EQ(cube.solve(solver), plain);
  EXPECT_EQ(changesOf(solver), "2");
  Archive written;
  written.enter("solver");
  solver.solver->serializeFor(cube.matrix, written);
  Archive reading = written.readable();
  reading.enter("solver");
  later.solver->serializeFor(cube.matrix, reading);
  EXPECT_EQ(cube.solve(later), plain);
  EXPECT_EQ(choiceOf(later), choiceOf(solver));
}

TEST(AutomaticPreconditioner, AChoiceIsTakenUpAgainAndTakenBack) {
  Beam beam(0);
  SolverInScene first("<PCGLinearSolver/>"), second("<PCGLinearSolver/>");
  beam.solve(first);
  first.solver->keepFor(beam.matrix);
  const int before = beam.solve(first);
  const Vector x = std::move(beam.x);
  Archive written;
  written.enter("solver");
  first.solver->serializeFor(beam.matrix, written);
  first.solver->takeBackFor(beam.matrix);
  EXPECT_EQ(beam.solve(first), before);
  EXPECT_EQ(std::memcmp(x.rows().data, beam.x.rows().data, x.rows().doubles() * sizeof(double)), 0);
  Archive reading = written.readable();
  reading.enter("solver");
  second.solver->serializeFor(beam.matrix, reading);
  EXPECT_EQ(beam.solve(second), before);
  EXPECT_EQ(std::memcmp(x.rows().data, beam.x.rows().data, x.rows().doubles() * sizeof(double)), 0);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
