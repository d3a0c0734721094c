// SPDX-License-Identifier: LGPL-2.1-or-later
// PCGLinearSolver where a scene names no preconditioner: block Jacobi as long as its iterations are few, multigrid, former factors
// or a direct solver when they are not.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "components/iterative_solvers/former_solve.h"
#include "components/iterative_solvers/solver_costs.h"
#include "tests/iterative_solvers/automatic_problems.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

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
        iteration((product > 0 ? product : IterationCosts::usual_product * rows) + IterationCosts::vectors(rows)),
        counts(dissected(blocks, countFactors(body.matrix.values))), factors(factorCosts(rows, blocks, counts)) {}
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
  double beforeFactors() const { 
    return factors.order + factors.factor + IterationCosts::assembly(rows) + IterationCosts::room(factors.entries);
  }
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
  cube.matrix.product_nanoseconds = 30. * cube.matrix.rows();
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
  cube.matrix.product_nanoseconds = 30. * cube.matrix.rows();
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
    after += says(choiceOf(solver), "by factors of each matrix") || says(choiceOf(solver), "factors instead of iterations");
  }
  EXPECT_EQ(after, 5) << choiceOf(solver);
}

/// Former factors do not serve here, and multigrid, for which they are given up, takes four times the iterations that were expected.
/// Then factors of each matrix come back, and not the thousand iterations of block Jacobi.
TEST(AutomaticPreconditioner, FactorsThatWereGivenUpComeBackWhereOthersCostMore) {
  for (const bool turns : {false, true}) {
    Needle needle;
    needle.matrix.has_turns = turns;
    SolverWhereMatricesVary solver("<PCGLinearSolver/>");
    for (int step = 0; step < 12; ++step) {
      const SolveReport report = needle.solve(solver);
      EXPECT_EQ(report.stop, SolveStop::converged);
      if (step >= 6) EXPECT_LT(report.iterations, 5) << choiceOf(solver);
    }
    EXPECT_TRUE(says(choiceOf(solver), "factors")) << choiceOf(solver);
  }
}

/// An assembly that takes as long as fifty hierarchies is not made for one.
TEST(AutomaticPreconditioner, AnAssemblyCostsWhatTheForceFieldsSay) {
  Cube cube(0.05), dear(0.05);
  for (Cube* each : {&cube, &dear}) each->matrix.product_nanoseconds = 100. * each->matrix.rows();
  dear.matrix.assembly_nanoseconds = 50 * Counts(dear).hierarchy();
  SolverWhereMatricesVary plain("<PCGLinearSolver/>"), solver("<PCGLinearSolver/>");
  for (int step = 0; step < 3; ++step) cube.solve(plain), dear.solve(solver);
  EXPECT_TRUE(says(choiceOf(plain), "by multigrid")) << choiceOf(plain);
  EXPECT_EQ(changesOf(solver), "0") << choiceOf(solver);
}

/// Laws of nested dissection are those of nodes that are tied to the next ones. Those of a wider pattern are counted.
TEST(AutomaticPreconditioner, FactorsOfWidePatternsAreCounted) {
  constexpr Index side = 12, reach = 2;
  BlockPattern wide(side * side * side);
  const auto at = [](Index i, Index j, Index k) { return i + side * (j + side * k); };
  for (Index a = 0; a < side * side * side; ++a)
    for (Index k = 0; k < side; ++k)
      for (Index j = 0; j < side; ++j)
        for (Index i = 0; i < side; ++i)
          if (std::max({std::abs(i - a % side), std::abs(j - a / side % side), std::abs(k - a / side / side)}) <= reach)
            wide.addBlock(a, at(i, j, k));
  const BlockMatrix matrix(std::move(wide));
  const FactorCounts counted = countFactors(matrix), law = factorCountsOf({side, side, side});
  EXPECT_TRUE(isWide(matrix));
  EXPECT_GT(counted.flops, 4 * law.flops);
  EXPECT_EQ(fewest(matrix, counted, {side, side, side}).flops, counted.flops);
  EXPECT_FALSE(isWide(Cube(0.05).matrix.values));
}

/// Stiff in one half and then in the other: factors of every second matrix, and a few iterations with them, cost less than its own.
TEST(AutomaticPreconditioner, TwoMatricesByTurnsShareFactors) {
  Beam beam(Beam::made(0, {4, 4, 120}));
  SolverWhereMatricesVary solver("<PCGLinearSolver/>");
  const BlockMatrix soft = beam.matrix.values;
  int most = 0;
  for (int step = 0; step < 24; ++step) {
    beam.matrix.values = soft;
    const auto isStiff = [&](Index k) { return (beam.matrix.nodes[std::size_t(k)].z() > 35) == (step % 2 == 0); };
    for (Index i = 0; i < soft.rows(); ++i)
      for (Index t = soft.rowStart()[i]; t < soft.rowStart()[i + 1]; ++t)
        if (isStiff(i) && isStiff(soft.columns()[t]))
          for (std::size_t k = 0; k < 9; ++k) beam.matrix.values.values()[9 * std::size_t(t) + k] *= 30;
    const int iterations = beam.solve(solver);
    if (step >= 12) most = std::max(most, iterations);
  }
  EXPECT_LE(std::stoi(solver.solver->data().find("factorisations")->print()), 12) << choiceOf(solver);
  EXPECT_LT(most, 20) << choiceOf(solver);
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

/// As the rows of constraints have: a direct solver is worth its factors after the first one, and takes the others at once.
TEST(AutomaticPreconditioner, ManyRightSidesGoThroughADirectSolverTogether) {
  constexpr std::size_t count = 40;
  Beam beam(0);
  SolverInScene solver("<PCGLinearSolver/>"), named("<SparseLDLSolver/>");
  for (int step = 0; step < 2; ++step) {
    ++beam.matrix.revision_number;
    beam.matrix.assemblies = 0;
    std::vector<Vector> b, x(count);
    std::vector<ConstRows> asked;
    std::vector<Rows> answers;
    for (std::size_t i = 0; i < count; ++i) b.push_back(randomVector(beam.matrix.rows(), unsigned(i))), x[i].resize(beam.matrix.rows());
    for (std::size_t i = 0; i < count; ++i) asked.push_back(b[i]), answers.push_back(x[i]);
    const SolveReport report = solver.solver->solveAll(beam.matrix, asked, answers);
    EXPECT_EQ(report.stop, SolveStop::converged) << describe(report.stop);
    EXPECT_LE(report.relative_residual, 1e-8);
    EXPECT_LT(beam.matrix.assemblies, 20) << "each direct solve asks for the matrix";
    for (const std::size_t i : {std::size_t(0), std::size_t(1), count - 1}) {
      Vector exact;
      named.solve(beam.matrix, b[i], exact);
      EXPECT_LT(distance(x[i], exact), 1e-4 * norm(exact)) << i;
    }
  }
  EXPECT_TRUE(says(choiceOf(solver), "factors instead of iterations")) << choiceOf(solver);
}

/// One step in which a body is much softer, so that block Jacobi takes several times the usual iterations, is waited for.
TEST(AutomaticPreconditioner, ASingleSlowSolveChangesNothing) {
  Cube heavy(5);
  const BlockMatrix usual = heavy.matrix.values, slow = Cube(0.3).matrix.values;
  SolverWhereMatricesVary solver("<PCGLinearSolver/>");
  int expected = 0;
  for (int step = 0; step < 12; ++step) expected = heavy.solve(solver);
  EXPECT_EQ(changesOf(solver), "0") << choiceOf(solver);
  heavy.matrix.values = slow;
  EXPECT_GT(heavy.solve(solver), 2 * expected);
  EXPECT_EQ(changesOf(solver), "0") << choiceOf(solver);
  heavy.matrix.values = usual;
  for (int step = 0; step < 3; ++step) EXPECT_EQ(heavy.solve(solver), expected);
  EXPECT_EQ(changesOf(solver), "0") << choiceOf(solver);
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

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
