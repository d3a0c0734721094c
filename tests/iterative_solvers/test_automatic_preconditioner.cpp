// SPDX-License-Identifier: LGPL-2.1-or-later
// PCGLinearSolver where a scene names no preconditioner: block Jacobi as long as its iterations are few, multigrid, former factors
// or a direct solver when they are not, and the same choices in a run that was taken up again.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <string>
#include <utility>

#include "components/iterative_solvers/former_solve.h"
#include "components/iterative_solvers/solver_costs.h"
#include "framework/scene/archive.h"
#include "tests/support/elastic_block.h"
#include "tests/support/solver_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// A beam of 3,479 nodes along z; `density` as the mass of an implicit step.
struct Beam {
  explicit Beam(double density) : Beam(made(density)) {}
  explicit Beam(StoredMatrix of) : matrix(std::move(of)), b(matrix.rows()) {
    for (Index i = 0; i < b.count(); ++i)
      if (matrix.nodes[std::size_t(i)].z() > 0) b[i] = Vec3(0.1, 0, -1);
  }
  static StoredMatrix made(double density, std::array<int, 3> cells = {6, 6, 70}) {
    ElasticBlock block;
    block.cells = cells;
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

/// A solver in a scene whose matrices depend on places, by a spring: what a scene without one shows its solver is known to stay.
struct SolverWhereMatricesVary : SolverInScene {
  explicit SolverWhereMatricesVary(const std::string& element)
      : SolverInScene(element + "<Node name=\"two\"><MechanicalObject position=\"0 0 0 1 0 0\"/><SpringForceField "
                      "springsIndices1=\"0\" springsIndices2=\"1\" lengths=\"1\" stiffness=\"1\" damping=\"0\"/></Node>") {}
};

std::string choiceOf(const SolverInScene& solver) { return solver.solver->data().find("choice")->print(); }
std::string changesOf(const SolverInScene& solver) { return solver.solver->data().find("changes")->print(); }
bool says(const std::string& text, const std::string& words) { return text.find(words) != std::string::npos; }

/// A compact body of 3,375 nodes, as Beam.
struct Cube : Beam {
  explicit Cube(double density, Index cells = 14) : Beam(cubeOf(density, cells)) {}
  static StoredMatrix cubeOf(double density, Index cells) {
    ElasticBlock block;
    block.cells = {cells, cells, cells};
    block.density = density;
    StoredMatrix matrix = block.matrix();
    for (Index k = 0; k < block.nodes(2); ++k)
      for (Index j = 0; j < block.nodes(1); ++j)
        for (Index i = 0; i < block.nodes(0); ++i) matrix.nodes.push_back(Vec3(i, j, k));
    return matrix;
  }
};

/// A solve that gets on slowly ends within, and goes on by another way.
TEST(AutomaticPreconditioner, ManyIterationsEndWithinASolve) {
  Beam beam(0);
  SolverInScene solver("<PCGLinearSolver/>"), named("<PCGLinearSolver preconditioner='block_jacobi'/>");
  EXPECT_TRUE(says(choiceOf(solver), "block Jacobi, or by multigrid or factors once")) << choiceOf(solver);
  const int plain = beam.solve(named);
  EXPECT_GT(plain, 320) << "block Jacobi is good enough here";
  EXPECT_LT(2 * beam.solve(solver), plain);
  EXPECT_NE(changesOf(solver), "0");
  EXPECT_TRUE(says(choiceOf(solver), "block Jacobi took")) << choiceOf(solver);
  for (int step = 0; step < 6; ++step) EXPECT_LT(beam.solve(solver), 40);
}

/// What the choice is made of: nanoseconds of a solve to 1e-8, of factors with what comes before (in one precision), and so on.
struct Counts {
  explicit Counts(const Beam& body, double product = 0)
      : rows(body.matrix.rows()), blocks(body.matrix.values.blocks()),
        iteration((product > 0 ? product : IterationCosts::usual_product * rows) + IterationCosts::vectors * rows),
        counts(dissected(blocks, countFactors(body.matrix.values))), factors(factorCosts(body.matrix.rows(), counts)) {}
  double jacobi(int iterations) const { return iterations * iteration; }
  double cycles(double iterations) const {
    return iterations * (iteration + IterationCosts::cycle(rows, blocks)) + IterationCosts::turns(rows, blocks);
  }
  /// Of hexahedra.
  double multigrid() const { return cycles(1.25 + 1.2 * 8); }
  /// Where they never age.
  double bestByFactors() const {
    const double each = iteration + factors.application;
    return std::ceil(8 * ratePerDecade(factors.is_single ? 5e-4 : 1e-5)) * each + iteration + IterationCosts::turns(rows, blocks);
  }
  double hierarchy() const { return IterationCosts::hierarchy(rows, blocks) + IterationCosts::assembly(rows); }
  double beforeFactors() const { return IterationCosts::order(blocks, counts) + factors.factor + 5.5 * factors.entries + 1e7; }
  double rows, blocks, iteration;
  FactorCounts counts;
  FactorCosts factors;
};

/// A hierarchy costs less than factors: it comes first, and stays where these would not cost less. With constant values they do.
TEST(AutomaticPreconditioner, ManyIterationsOfACompactBodyBringMultigrid) {
  Cube cube(0);
  const Counts counts(cube);
  EXPECT_LT(counts.hierarchy(), counts.beforeFactors());
  SolverWhereMatricesVary solver("<PCGLinearSolver/>");
  cube.solve(solver);
  EXPECT_TRUE(says(choiceOf(solver), "by multigrid: block Jacobi took")) << choiceOf(solver);
  for (int step = 0; step < 12; ++step) {
    const int iterations = cube.solve(solver);
    EXPECT_LT(counts.cycles(iterations), 1.15 * counts.bestByFactors()) << iterations << " iterations";
  }
  EXPECT_EQ(changesOf(solver), "1");
  SolverInScene constant("<PCGLinearSolver/>");
  for (int step = 0; step < 120 && !says(choiceOf(constant), "factors"); ++step) cube.solve(constant);
  EXPECT_TRUE(says(choiceOf(constant), "factors")) << choiceOf(constant);
}

/// How long factors would serve is seen without them: here no value changes. They are taken once they pay in as many solves as
/// there have been, and 8 more.
TEST(AutomaticPreconditioner, FactorsAreTakenOnceTheyWouldPay) {
  Cube cube(0.02, 6);
  cube.matrix.product_nanoseconds = 10. * cube.matrix.rows();
  const Counts counts(cube, cube.matrix.product_nanoseconds);
  SolverWhereMatricesVary solver("<PCGLinearSolver/>"), named("<PCGLinearSolver preconditioner='block_jacobi'/>");
  const int iterations = cube.solve(named);
  const double each = counts.jacobi(iterations), best = counts.bestByFactors();
  ASSERT_GT(each, 1.25 * best);
  const double enough = std::max(1.0, counts.beforeFactors() / (each - best) - 8);
  EXPECT_LT(enough, 100);
  int solves = 0;
  while (solves < 200 && cube.solve(solver) == iterations) ++solves;
  EXPECT_NEAR(solves, enough, 2 + enough / 4);
  EXPECT_TRUE(says(choiceOf(solver), "by factors of former")) << choiceOf(solver);
  for (int step = 0; step < 10; ++step) EXPECT_LT(cube.solve(solver), 5);
  EXPECT_EQ(changesOf(solver), "1");
}

/// The same body, stiffer above and then below by turns: nothing is factored to see that factors would not serve.
TEST(AutomaticPreconditioner, FactorsThatWouldNotServeAreNotTried) {
  Cube cube(0.02, 6);
  cube.matrix.product_nanoseconds = 10. * cube.matrix.rows();
  SolverWhereMatricesVary solver("<PCGLinearSolver/>"), same("<PCGLinearSolver/>");
  for (int step = 0; step < 90; ++step) cube.solve(same);
  EXPECT_TRUE(says(choiceOf(same), "by factors of former")) << choiceOf(same);
  const BlockMatrix soft = cube.matrix.values;
  for (int step = 0; step < 60; ++step) {
    cube.matrix.values = soft;
    const auto isStiff = [&](Index k) { return (cube.matrix.nodes[std::size_t(k)].z() > 3) == (step % 2 == 0); };
    for (Index i = 0; i < soft.rows(); ++i)
      for (Index t = soft.rowStart()[i]; t < soft.rowStart()[i + 1]; ++t)
        if (isStiff(i) && isStiff(soft.columns()[t]))
          for (std::size_t k = 0; k < 9; ++k) cube.matrix.values.values()[9 * std::size_t(t) + k] *= 30;
    cube.solve(solver);
  }
  EXPECT_EQ(solver.solver->data().find("factorisations")->print(), "0") << choiceOf(solver);
}

/// Where the next matrix is another one altogether each is factored: in the room that there is, by the order that there is.
TEST(AutomaticPreconditioner, MatricesThatFormerFactorsDoNotServeAreFactoredEach) {
  Beam beam(Beam::made(0, {4, 4, 120}));
  SolverWhereMatricesVary solver("<PCGLinearSolver/>");
  const BlockMatrix soft = beam.matrix.values;
  int after = 0;
  for (int step = 0; step < 24 && after < 5; ++step) {
    beam.matrix.values = soft;
    // S A S, S of each node another number between a tenth and ten
    const auto scaleOf = [&](Index k) { return std::pow(10., std::sin((step % 5 + 1) * beam.matrix.nodes[std::size_t(k)].z())); };
    for (Index i = 0; i < soft.rows(); ++i)
      for (Index t = soft.rowStart()[i]; t < soft.rowStart()[i + 1]; ++t)
        for (std::size_t k = 0; k < 9; ++k)
          beam.matrix.values.values()[9 * std::size_t(t) + k] *= scaleOf(i) * scaleOf(soft.columns()[t]);
    const int iterations = beam.solve(solver);
    if (after > 0) EXPECT_LT(iterations, 5) << choiceOf(solver);
    after += says(choiceOf(solver), "by factors of each matrix");
  }
  EXPECT_EQ(after, 5) << choiceOf(solver);
}

/// Of a linear body, or with the many right sides of constraints.
TEST(AutomaticPreconditioner, SolvesWithOneMatrixShareFactors) {
  Beam beam(0);
  SolverInScene solver("<PCGLinearSolver/>");
  for (int k = 0; k < 12; ++k) {
    beam.solve(solver);
    --beam.matrix.revision_number;
  }
  EXPECT_TRUE(says(choiceOf(solver), "factors")) << choiceOf(solver);
  EXPECT_LE(std::stoi(solver.solver->data().find("factorisations")->print()), 2);
}

TEST(AutomaticPreconditioner, AMassThatKeepsIterationsFewKeepsBlockJacobi) {
  Beam beam(5);
  SolverInScene solver("<PCGLinearSolver/>"), named("<PCGLinearSolver preconditioner='block_jacobi'/>");
  for (int step = 0; step < 10; ++step) {
    const int found = beam.solve(solver);
    const Vector own = std::move(beam.x);
    EXPECT_LT(found, 100);
    EXPECT_EQ(beam.solve(named), found);
    EXPECT_EQ(std::memcmp(own.rows().data, beam.x.rows().data, own.rows().doubles() * sizeof(double)), 0);
  }
  EXPECT_EQ(changesOf(solver), "0");
  EXPECT_EQ(beam.matrix.assemblies, 0);
}

/// Where elements multiply up to so many times for less than an assembly, solves that take fewer iterations get no matrix, those
/// that take more get one at once. What a loose solve took counts for the digits that it gained.
TEST(AutomaticPreconditioner, TheMatrixIsAssembledWhereIterationsSeenPayForIt) {
  Beam heavy(5), light(0.5);
  heavy.matrix.assembled_from = 60, light.matrix.assembled_from = 20;
  SolverInScene plain("<PCGLinearSolver/>"), solver("<PCGLinearSolver/>");
  for (int step = 0; step < 4; ++step) EXPECT_LT(heavy.solve(plain), 60);
  EXPECT_EQ(heavy.matrix.assemblies, 1) << "before anything was seen";
  const auto solve = [&](double target) {
    Vector x(light.b.count());
    ++light.matrix.revision_number;
    return solver.solver->solve(light.matrix, light.b, x, {.relative_residual = target}).iterations;
  };
  for (int step = 0; step < 2; ++step) EXPECT_LT(solve(0.1), 20);
  EXPECT_EQ(light.matrix.assemblies, 0);
  const int products = light.matrix.products;
  for (int step = 0; step < 2; ++step) EXPECT_GT(solve(0), 20);
  EXPECT_EQ(light.matrix.assemblies, 2);
  EXPECT_EQ(light.matrix.products, products);
}

/// Of a first solve too few iterations may be expected: it goes on with a matrix once that would have paid.
TEST(AutomaticPreconditioner, ASolveThatTakesLongGoesOnWithAMatrix) {
  Beam beam(0.02);
  beam.matrix.assembled_from = 27;
  SolverInScene solver("<PCGLinearSolver/>");
  Vector x(beam.b.count());
  EXPECT_GT(solver.solver->solve(beam.matrix, beam.b, x, {.relative_residual = 0.01}).iterations, 28);
  EXPECT_EQ(beam.matrix.products, 28);
  EXPECT_GE(beam.matrix.assemblies, 1);
}

/// The same body with products that cost ten times as much, as those of hyperelastic hexahedra: a V-cycle is then worth more
/// iterations of block Jacobi.
TEST(AutomaticPreconditioner, DearProductsBringMultigridEarlier) {
  Cube cheap(0.05), dear(0.05);
  cheap.matrix.product_nanoseconds = 10. * cheap.matrix.rows();
  dear.matrix.product_nanoseconds = 100. * dear.matrix.rows();
  SolverWhereMatricesVary plain("<PCGLinearSolver/>"), solver("<PCGLinearSolver/>");
  const int many = cheap.solve(plain);
  const Counts cheaply(cheap, cheap.matrix.product_nanoseconds), dearly(dear, dear.matrix.product_nanoseconds);
  EXPECT_LT(cheaply.jacobi(many), 1.15 * cheaply.multigrid()) << many << " iterations";
  EXPECT_GT(dearly.jacobi(many), 1.15 * dearly.multigrid()) << many << " iterations";
  EXPECT_GT(11 * (dearly.jacobi(many) - dearly.multigrid()), dearly.hierarchy());
  int found = many;
  for (int step = 0; step < 2; ++step) found = dear.solve(solver);
  EXPECT_EQ(changesOf(solver), "1") << many << " iterations";
  EXPECT_LT(found, 25);
  EXPECT_TRUE(says(choiceOf(solver), "by multigrid")) << choiceOf(solver);
  EXPECT_LT(2 * cheaply.jacobi(many), cheaply.beforeFactors());
  for (int step = 0; step < 2; ++step) EXPECT_EQ(cheap.solve(plain), many);
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

/// Fifteen times as long as wide, and stiff in one half and then in the other: no former factors serve, and a direct solver costs
/// least. `shift` times the identity makes it indefinite with a positive diagonal.
struct Needle {
  Needle() : matrix(made(false)), other(made(true).values), b(matrix.rows()) {
    for (Index i = 25; i < b.count(); ++i) b[i] = Vec3(0.1, 0, -1);
  }
  static StoredMatrix made(bool is_stiff_above) {
    ElasticBlock block;
    block.cells = {4, 4, 60};
    block.poisson = 0.49;
    block.stiffer = [is_stiff_above](Vec3 at) { return (at.z() > 30) == is_stiff_above ? 10. : 1.; };
    StoredMatrix matrix = block.matrix();
    for (Index k = 0; k < block.nodes(2); ++k)
      for (Index j = 0; j < block.nodes(1); ++j)
        for (Index i = 0; i < block.nodes(0); ++i) matrix.nodes.push_back(Vec3(i, j, k));
    return matrix;
  }
  SolveReport solve(SolverInScene& solver, double shift = 0) {
    ++matrix.revision_number;
    std::swap(matrix.values, other);
    for (Index i = 0; i < matrix.rows(); ++i) matrix.values.add(i, i, shift * Mat3::Identity());
    x = Vector(b.count());
    const SolveReport report = solver.solve(matrix, b, x);
    Vector r(b.count());
    matrix.values.multiply(x, r);
    residual = distance(r, b) / norm(b);
    for (Index i = 0; i < matrix.rows(); ++i) matrix.values.add(i, i, -shift * Mat3::Identity());
    return report;
  }
  StoredMatrix matrix;
  BlockMatrix other;  ///< of the next solve
  Vector b, x;
  double residual = 0;
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

/// Factors that never serve the next matrix are made for each one, instead of a trial with every second one.
TEST(WarpedFactor, MatricesThatFactorsDoNotServeAreFactoredAtOnce) {
  Needle needle;
  SolverInScene solver("<PCGLinearSolver preconditioner='warped'/><SparseLDLSolver/>");
  int slow = 0;
  for (int step = 0; step < 30; ++step) slow += needle.solve(solver).iterations > 8;
  EXPECT_GT(slow, 0);
  EXPECT_LT(slow, 6);
}

/// What the turned factors of a former matrix leave of its own solve.
TEST(FormerSolve, DriftIsThatOfTheMatrix) {
  Beam beam(0.2);
  SolverInScene solver("<PCGLinearSolver tolerance='1e-12' preconditioner='block_jacobi'/>");
  beam.solve(solver);
  FormerSolve former;
  former.keep(beam.matrix, 1, beam.b, beam.x);
  EXPECT_LT(former.drift(beam.matrix), 1e-9);
  // A + 0.1 A leaves r = 0.1 b, in the norm of 1.1 D
  double sum = 0;
  std::vector<double> blocks;
  beam.matrix.diagonalBlocks(blocks);
  for (Index i = 0; i < beam.b.count(); ++i)
    sum += Vec3(beam.b[i]).dot(Eigen::Map<const Mat3>(blocks.data() + 9 * std::size_t(i)).inverse() * Vec3(beam.b[i]));
  for (double& value : beam.matrix.values.values()) value *= 1.1;
  EXPECT_NEAR(former.drift(beam.matrix), 0.1 * std::sqrt(sum / 1.1 / dot(beam.x, beam.b)), 1e-9);
  for (double& value : beam.matrix.values.values()) value /= 1.1;
  // and one that is turned with its nodes has not drifted
  const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  for (Vec3& node : beam.matrix.nodes) node = turn * node;
  for (std::size_t s = 0; s < beam.matrix.values.values().size() / 9; ++s) {
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> block(beam.matrix.values.values().data() + 9 * s);
    block = (turn * block * turn.transpose()).eval();
  }
  EXPECT_LT(former.drift(beam.matrix), 1e-3);
  Drifts drifts;
  drifts.note(1, 0.01);
  EXPECT_NEAR(drifts.after(5), 0.05, 1e-12);
  drifts.note(3, 0.02);
  EXPECT_NEAR(drifts.after(5), 0.03, 1e-12);
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
