// SPDX-License-Identifier: LGPL-2.1-or-later
// AutomaticLinearSolver on blocks of hexahedra that no component made: what it chooses, when it changes its choice, what a
// checkpoint has of it.
#include <gtest/gtest.h>

#include "components/iterative_solvers/equilibrium_choice.h"
#include "components/iterative_solvers/solver_costs.h"
#include "tests/iterative_solvers/block_problem.h"

namespace stroma::test {
namespace {

/// The matrix of springs between each node and its neighbours along the axes.
void keepNeighbours(StoredMatrix& matrix) {
  BlockPattern pattern(matrix.rows());
  for (Index i = 0; i < matrix.rows(); ++i) pattern.addBlock(i, i);
  const auto isNeighbour = [&](Index a, Index b) { return (matrix.nodes[a] - matrix.nodes[b]).squaredNorm() < 1.5; };
  for (Index i = 0; i < matrix.rows(); ++i)
    for (Index s = matrix.values.rowStart()[i]; s < matrix.values.rowStart()[i + 1]; ++s)
      if (const Index j = matrix.values.columns()[s]; isNeighbour(i, j)) pattern.addBlock(i, j);
  BlockMatrix springs(std::move(pattern));
  for (Index i = 0; i < matrix.rows(); ++i)
    for (Index s = springs.rowStart()[i]; s < springs.rowStart()[i + 1]; ++s)
      springs.add(s, springs.columns()[s] == i ? Mat3(7 * Mat3::Identity()) : Mat3(-Mat3::Identity()));
  matrix.values = std::move(springs);
}

TEST(SolverCosts, ShapesOfBodiesAreFound) {
  const StoredMatrix beam = matrixOf(box(6, 6, 60));
  const Extents extents = extentsOf(beam.rows(), beam.positions());
  EXPECT_NEAR(extents.length, 61, 3);
  EXPECT_NEAR(extents.width, 7, 1);
  EXPECT_NEAR(extents.height, 7, 1);
  Vector line(400);  // two nodes wide and high is the least
  for (Index i = 0; i < line.count(); ++i) line[i] = Vec3(0.01 * i, 0, 0);
  const Extents chain = extentsOf(line.count(), line);
  EXPECT_NEAR(chain.length, 100, 1e-9);
  EXPECT_NEAR(chain.width, 2, 1e-9);
  EXPECT_NEAR(chain.height, 2, 1e-9);
  const Extents unknown = extentsOf(1000, {});
  EXPECT_NEAR(unknown.width, 10, 1e-9);
}

// What the choice rests on is what factors are: of a cube, a beam and a plate.
TEST(SolverCosts, NumbersAreThoseOfFactors) {
  for (const ElasticBlock& block : {box(12, 12, 12), box(6, 6, 60), box(36, 28, 4)}) {
    StoredMatrix matrix = matrixOf(block);
    SolverInScene factors("<SparseLDLSolver/>");
    Vector x;
    factors.solve(matrix, weight(block), x);
    const double made = std::stod(factors.solver->data().find("factorEntries")->print());
    const double law = factorCountsOf(extentsOf(matrix.rows(), matrix.positions())).entries;
    EXPECT_GT(law, 0.6 * made) << block.cells[0];
    EXPECT_LT(law, 1.6 * made) << block.cells[0];
  }
}

/// The pattern of a box of 12 x 8 x 4 cubes, each cut into six tetrahedra along its diagonal, or whole. Quadratic tetrahedra have a
/// node in the middle of each edge.
enum class Cells { tetrahedra, quadratic, hexahedra };
BlockMatrix patternOf(Cells kind, bool has_hub = false) {
  constexpr int l = 12, m = 8, n = 4;
  const int step = kind == Cells::quadratic ? 2 : 1;
  using Place = std::array<int, 3>;
  const auto at = [&](const Place& place) {
    return Index((place[0] * (step * m + 1) + place[1]) * (step * n + 1) + place[2]);
  };
  BlockPattern pattern(Index(step * l + 1) * (step * m + 1) * (step * n + 1));
  for (int cell = 0; cell < l * m * n; ++cell) {
    const Place corner{step * (cell / (m * n)), step * (cell / n % m), step * (cell % n)};
    std::vector<Index> nodes;
    for (int k = 0; k < 8; ++k)
      nodes.push_back(at({corner[0] + step * (k & 1), corner[1] + step * (k >> 1 & 1), corner[2] + step * (k >> 2)}));
    if (kind == Cells::hexahedra) pattern.addClique(nodes.data(), int(nodes.size()));
    std::array<int, 3> axes{0, 1, 2};
    do {
      std::array<Place, 4> corners{corner, corner, corner, corner};
      for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t later = k + 1; later < 4; ++later) corners[later][std::size_t(axes[k])] += step;
      nodes.clear();
      for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = i; j < 4; ++j) {
          const Place& a = corners[i];
          const Place& b = corners[j];
          if (i == j || kind == Cells::quadratic) nodes.push_back(at({(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2}));
        }
      pattern.addClique(nodes.data(), int(nodes.size()));
    } while (std::next_permutation(axes.begin(), axes.end()));
  }
  for (Index node = 1; has_hub && node < 100; ++node) pattern.addClique(std::array<Index, 2>{0, node}.data(), 2);
  return BlockMatrix(std::move(pattern));
}

// Rows of quadratic tetrahedra have as many blocks as those of hexahedra on average, and take three times the iterations.
TEST(SolverCosts, CellsAreToldByTheirPatterns) {
  EXPECT_NEAR(expectedMultigridRate(patternOf(Cells::tetrahedra)), 2, 0.1);
  EXPECT_NEAR(expectedMultigridRate(patternOf(Cells::hexahedra)), 1.3, 0.2);
  EXPECT_NEAR(expectedMultigridRate(patternOf(Cells::quadratic)), 3.1, 1e-9);
  // springs from one node to a hundred others leave hexahedra what they are
  EXPECT_NEAR(expectedMultigridRate(patternOf(Cells::hexahedra, true)), 1.3, 0.2);
}

/// Measured of blocks of 16^3 hexahedra: 1.22 of cubes, 1.59 of cells twice as long as wide, 2.01 and 2.89 of flat ones.
TEST(SolverCosts, StretchedCellsTakeMoreIterations) {
  const BlockMatrix pattern = patternOf(Cells::hexahedra);
  const auto rateOf = [&](double a, double b, double c) {
    Vector x(pattern.rows());
    for (Index row = 0; row < x.count(); ++row) x[row] = Vec3(a * double(row / 45), b * double(row / 5 % 9), c * double(row % 5));
    return expectedMultigridRate(pattern, x);
  };
  const double of_cubes = rateOf(1, 1, 1);
  EXPECT_NEAR(of_cubes, expectedMultigridRate(pattern), 0.02);
  EXPECT_NEAR(rateOf(2, 1, 1) - of_cubes, 1.59 - 1.22, 0.15);
  EXPECT_NEAR(rateOf(2, 2, 1) - of_cubes, 2.01 - 1.22, 0.15);
  EXPECT_NEAR(rateOf(3, 3, 1) - of_cubes, 2.89 - 1.22, 0.25);
}

// A second order is looked for where factorisations are dear, and estimates know it.
TEST(SolverCosts, NestedDissectionIsTriedWhereItPays) {
  for (const ElasticBlock& block : {box(13, 13, 13), box(6, 6, 70)}) {
    StoredMatrix matrix = matrixOf(block);
    SolverInScene factors("<SparseLDLSolver/>");
    Vector x;
    factors.solve(matrix, weight(block), x);
    const bool is_dissected = isDissected(matrix.values.blocks(), countFactors(matrix.values));
    EXPECT_EQ(is_dissected, block.cells[0] == 13);
    EXPECT_EQ(factors.solver->data().find("ordering")->print(), is_dissected ? "METIS" : "AMD");
  }
}

// Counted in a pattern: a slender beam, a cube and a slab, of hexahedra, and of nodes that touch their six neighbours alone, where
// laws have several times too many.
TEST(FactorCounts, AreThoseOfFactors) {
  for (const bool is_sparse : {false, true})
    for (const ElasticBlock& block : {box(4, 4, 120), box(9, 9, 9), box(30, 20, 3)}) {
      StoredMatrix matrix = matrixOf(block);
      if (is_sparse) keepNeighbours(matrix);
      SolverInScene factors("<SparseLDLSolver/>");
      Vector x;
      factors.solve(matrix, weight(block), x);
      const double made = std::stod(factors.solver->data().find("factorEntries")->print());
      const double counted = countFactors(matrix.values).entries;
      EXPECT_GT(counted, made / 1.5) << block.cells[2] << is_sparse;
      EXPECT_LT(counted, made * 1.5) << block.cells[2] << is_sparse;
    }
}

// A cube of 13,824 nodes is solved by multigrid where the scene is silent; where that takes too long, by factors, and the
// solver says so.
TEST(AutomaticLinearSolver, ChangesAChoiceThatProvesWrong) {
  ElasticBlock block = box(16, 16, 16);
  const auto solve = [&](double poisson) {
    block.poisson = poisson;
    StoredMatrix matrix = matrixOf(block);
    const Vector b = weight(block);
    SolverInScene solver("<AutomaticLinearSolver/>");
    Vector x;
    const SolveReport report = solver.solve(matrix, b, x);
    EXPECT_EQ(report.stop, SolveStop::converged);
    EXPECT_LE(report.relative_residual, 1.1e-8);
    return solver.solver->data().find("choice")->print();
  };
  EXPECT_NE(solve(0.3).find("multigrid: 4913 nodes"), std::string::npos) << solve(0.3);
  EXPECT_NE(solve(0.499999).find("factors, after"), std::string::npos) << solve(0.499999);
}

/// Factors need a module with libraries of its own: a scene that is solved by multigrid has none of its components, and does not wait
/// for it. A direct solver that stands there is the one that factors.
TEST(AutomaticLinearSolver, MakesADirectSolverWhenItWantsOne) {
  StoredMatrix small = matrixOf(box(4, 4, 4)), large = matrixOf(box(16, 16, 16));
  for (const bool stands : {false, true}) {
    SolverInScene solver(stands ? "<AutomaticLinearSolver/><SparseLDLSolver/>" : "<AutomaticLinearSolver/>");
    const auto told = [&](const char* name) { return solver.solver->data().find(name)->print(); };
    EXPECT_EQ(solver.scene.root->components().size(), stands ? 2u : 1u);
    Vector x, y;
    EXPECT_EQ(solver.solve(large, weight(box(16, 16, 16)), x).stop, SolveStop::converged);
    EXPECT_NE(told("choice").find("with multigrid: 4913 nodes"), std::string::npos) << told("choice");
    const SolveReport factored = solver.solve(small, weight(box(4, 4, 4)), y);
    EXPECT_TRUE(factored.factored);
    EXPECT_NE(told("choice").find("SparseLDLSolver factors: 125 nodes are few"), std::string::npos) << told("choice");
  }
}

/// A thin plate that hardly changes its volume: a hierarchy needs patches there, and then costs more than factors. A thicker one of
/// as many nodes whose volume changes is solved by multigrid; so is the plate where factors cost more than four times as much.
TEST(AutomaticLinearSolver, WhereDiagonalBlocksHardlySmoothFactorsCostLess) {
  const auto told = [](double poisson, SolverInScene& solver, StoredMatrix& matrix) {
    Vector x;
    const ElasticBlock shape = box(30, 24, 5);
    EXPECT_EQ(solver.solve(matrix, weight(shape), x).stop, SolveStop::converged) << poisson;
    return solver.solver->data().find("choice")->print();
  };
  for (const double poisson : {0.3, 0.4995}) {
    ElasticBlock block = box(30, 24, 5);
    block.poisson = poisson, block.mean = true;
    StoredMatrix matrix = matrixOf(block);
    const SolverCosts costs = solverCosts(matrix, countFactors(matrix.values));
    EXPECT_LT(costs.multigrid, costs.direct);
    EXPECT_LT(costs.direct, IterationCosts::with_patches * costs.multigrid);
    SolverInScene solver("<AutomaticLinearSolver/>"), later("<AutomaticLinearSolver/>");
    const std::string choice = told(poisson, solver, matrix);
    EXPECT_NE(choice.find(poisson < 0.4 ? "with multigrid: " : "factors: "), std::string::npos) << choice;
    EXPECT_EQ(choice.find("hardly smooth") == std::string::npos, poisson < 0.4) << choice;
    Archive written;
    written.enter("solver");
    solver.solver->serializeFor(matrix, written);
    Archive reading = written.readable();
    reading.enter("solver");
    later.solver->serializeFor(matrix, reading);
    EXPECT_EQ(told(poisson, later, matrix), choice);
  }
}

/// A residual that round-off leaves is no reason for factors, which leave as much: bones 1e8 times as stiff as the limb around
/// them.
TEST(AutomaticLinearSolver, WhatRoundOffLeavesIsNoWrongChoice) {
  ElasticBlock limb = box(14, 14, 36);
  limb.poisson = 0.45, limb.mean = true;
  limb.stiffer = [](Vec3 at) { return std::hypot(at.x() - 7, at.y() - 7) < 4 && std::abs(at.z() - 18) > 3 ? 1e8 : 1.; };
  StoredMatrix matrix = matrixOf(limb);
  const Vector b = weight(limb);
  SolverInScene automatic("<AutomaticLinearSolver/>"), factors("<SparseLDLSolver/>");
  Vector x, y, r(b.count());
  const auto left = [&](const Vector& solution) {
    matrix.values.multiply(solution, r);
    return distance(r, b) / norm(b);
  };
  automatic.solve(matrix, b, x);
  factors.solve(matrix, b, y);
  EXPECT_GT(left(y), 1e-6) << "round-off does not show";
  EXPECT_LE(left(x), 2 * left(y));
  EXPECT_EQ(automatic.solver->data().find("changes")->print(), "0") << automatic.solver->data().find("choice")->print();
  EXPECT_LE(distance(x, y), 1e-3 * norm(y));
}

/// A hierarchy of the matrix as it was says nothing of what the matrix has become: one of its own is tried before factors are.
TEST(AutomaticLinearSolver, AFormerHierarchyDoesNotDecideForFactors) {
  ElasticBlock block = box(9, 9, 36), boned = block;
  boned.stiffer = [](Vec3 at) { return std::abs(at.x() - 4.5) < 2 && std::abs(at.y() - 4.5) < 2 ? 1e4 : 1.; };
  StoredMatrix matrix = matrixOf(block);
  const Vector b = weight(block);
  const int patience = solverCosts(matrix, countFactors(matrix.values)).patience();
  SolverInScene solver("<AutomaticLinearSolver/>");
  const auto told = [&](const char* name) { return solver.solver->data().find(name)->print(); };
  Vector x;
  ASSERT_LT(solver.solve(matrix, b, x).iterations, patience);
  const int assemblies = matrix.assemblies;
  matrix.values = matrixOf(boned).values;
  ++matrix.revision_number;
  x = Vector(b.count());
  const SolveReport report = solver.solve(matrix, b, x);
  EXPECT_EQ(report.stop, SolveStop::converged) << describe(report.stop);
  EXPECT_GT(report.iterations, patience / 2) << "the former hierarchy serves it as well, with patches";
  EXPECT_LT(report.iterations, 2 * patience);
  EXPECT_EQ(matrix.assemblies, assemblies + 1);
  EXPECT_NE(told("choice").find("with multigrid"), std::string::npos) << told("choice");
  EXPECT_EQ(told("changes"), "0");
}

/// Where no force depends on the state, a checkpoint has the places of the nodes instead of the hierarchy, which is made again
/// from these and not from where the nodes are by then.
TEST(AutomaticLinearSolver, WritesOnlyHierarchiesThatCannotBeMadeAgain) {
  ElasticBlock block = box(16, 16, 16);
  const std::string law = R"(<MechanicalObject position="0 0 0  1 0 0  0 1 0  0 0 1"/>
    <MeshTopology position="0 0 0  1 0 0  0 1 0  0 0 1" tetrahedra="0 1 2 3"/>
    <TetrahedronFEMForceField youngModulus="5000" poissonRatio="0.3" method=)";
  for (const bool depends : {false, true}) {
    const std::string scene = "<AutomaticLinearSolver/>" + law + (depends ? "\"svd\"/>" : "\"small\"/>");
    SolverInScene first(scene), second(scene);
    StoredMatrix matrix = matrixOf(block);
    ASSERT_FALSE(matrix.nodes.empty());
    Vector x, y;
    first.solve(matrix, weight(block), x);
    for (Vec3& node : matrix.nodes) node.x() += 0.1 * node.z() * node.z();
    Archive written;
    written.enter("solver");
    first.solver->serializeFor(matrix, written);
    std::size_t bytes = 0;
    for (const auto& [name, entry] : written.entries()) bytes += entry.bytes.size();
    EXPECT_EQ(bytes < 64 * std::size_t(matrix.rows()), !depends) << bytes;
    Archive reading = written.readable();
    reading.enter("solver");
    second.solver->serializeFor(matrix, reading);
    x = Vector(matrix.rows());
    const int again = first.solve(matrix, weight(block), x).iterations;
    EXPECT_EQ(second.solve(matrix, weight(block), y).iterations, again);
    EXPECT_EQ(std::memcmp(x.rows().data, y.rows().data, x.rows().doubles() * sizeof(double)), 0);
  }
}

/// What was given up and why is known to a run that is taken up again, and to a step that is taken back.
TEST(AutomaticLinearSolver, TellsAChoiceOfTheRunBefore) {
  ElasticBlock block = box(16, 16, 16);
  block.poisson = 0.499999;
  StoredMatrix matrix = matrixOf(block);
  SolverInScene first("<AutomaticLinearSolver/>"), second("<AutomaticLinearSolver/>");
  const auto told = [](const SolverInScene& solver, const char* name) { return solver.solver->data().find(name)->print(); };
  Vector x;
  first.solver->keepFor(matrix);
  const std::string before = told(first, "choice");
  EXPECT_NE(before.find("with multigrid"), std::string::npos) << before;
  first.solve(matrix, weight(block), x);
  handOver(first, second, matrix);
  EXPECT_NE(told(second, "choice").find("factors, after"), std::string::npos) << told(second, "choice");
  EXPECT_EQ(told(second, "choice"), told(first, "choice"));
  EXPECT_EQ(told(second, "changes"), "1");
  first.solver->takeBackFor(matrix);
  EXPECT_EQ(told(first, "choice"), before);
  EXPECT_EQ(told(first, "changes"), "0");
}

/// With a force that depends on the state, so that solves are those of Newton's method.
const std::string solver_of_many = R"(<AutomaticLinearSolver/><MechanicalObject position="0 0 0  1 0 0  0 1 0  0 0 1"/>
    <MeshTopology position="0 0 0  1 0 0  0 1 0  0 0 1" tetrahedra="0 1 2 3"/>
    <TetrahedronFEMForceField youngModulus="5000" poissonRatio="0.3" method="svd"/>)";

/// A thin plate that hardly changes its volume, which is factored.
StoredMatrix thinPlate() {
  ElasticBlock plate = box(30, 24, 5);
  plate.poisson = 0.4995, plate.mean = true;
  return matrixOf(plate);
}

/// Later matrices of Newton's method are near former ones: factors serve them once a trial is a small share of what all cost, and a run
/// that is taken up again has them.
TEST(AutomaticLinearSolver, FactorsServeLaterMatrices) {
  StoredMatrix matrix = thinPlate();
  const Vector b = weight(box(30, 24, 5));
  SolverInScene first(solver_of_many), second(solver_of_many);
  Vector x, y(b.count()), r(b.count());
  const SolveTerms loose{.relative_residual = 0.1};
  EXPECT_TRUE(first.solve(matrix, b, x).factored);
  EXPECT_NE(first.solver->data().find("choice")->print().find("they serve later matrices too"), std::string::npos);
  for (int step = 1; step <= 6; ++step) {
    for (Index row = 0; row < matrix.rows(); row += 7) matrix.values.add(matrix.values.diagonal()[row], 0.001 * Mat3::Identity());
    ++matrix.revision_number;
    if (step == 6) handOver(first, second, matrix);
    x = Vector(b.count());
    const SolveReport report = first.solver->solve(matrix, b, x, loose);
    EXPECT_TRUE(step < 4 || !report.factored) << step;
    EXPECT_EQ(report.stop, SolveStop::converged);
    EXPECT_TRUE(step < 4 || report.iterations > 1) << step;
    matrix.values.multiply(x, r);
    EXPECT_LE(distance(r, b), 1.2 * EquilibriumChoice::by_former * norm(b));
  }
  second.solver->solve(matrix, b, y, loose);
  EXPECT_EQ(std::memcmp(x.rows().data, y.rows().data, x.rows().doubles() * sizeof(double)), 0);
}

/// That a matrix is not definite is for its own factors to say, and where: former ones are not tried for ever then.
TEST(AutomaticLinearSolver, MatricesThatAreNotDefiniteAreFactored) {
  StoredMatrix matrix = thinPlate();
  const Vector b = weight(box(30, 24, 5));
  SolverInScene solver(solver_of_many);
  Vector x;
  solver.solve(matrix, b, x);
  const std::vector<double> definite = matrix.values.values();
  for (int turn = 0; turn < 3; ++turn) {
    for (Index row = 2000; row < 2010; ++row) matrix.values.add(matrix.values.diagonal()[row], -1e3 * Mat3::Identity());
    ++matrix.revision_number, x = Vector(b.count());
    const SolveReport refused = solver.solve(matrix, b, x);
    EXPECT_EQ(refused.stop, SolveStop::not_definite);
    EXPECT_GE(refused.row, 0);
    matrix.values.values() = definite;
    ++matrix.revision_number, x = Vector(b.count());
    EXPECT_EQ(solver.solve(matrix, b, x).stop, SolveStop::converged);
  }
  ++matrix.revision_number, x = Vector(b.count());
  EXPECT_TRUE(solver.solve(matrix, b, x).factored) << "former factors are no longer tried";
}

/// Whether products go by elements or by a matrix follows from the iterations of the solve before: loose ones take fewer than the
/// eight that the first is expected to take.
TEST(AutomaticLinearSolver, ExpectsWhatTheLastSolveTook) {
  const ElasticBlock block = box(14, 14, 14);
  StoredMatrix matrix = matrixOf(block);
  matrix.assembled_from = 7;
  SolverInScene solver("<AutomaticLinearSolver/>");
  const Vector b = weight(block);
  Vector x(b.count());
  const auto productsOf = [&](double left) {
    ++matrix.revision_number;
    const int before = matrix.products;
    clear(x);
    const SolveReport report = solver.solver->solve(matrix, b, x, {.relative_residual = left});
    EXPECT_EQ(report.stop, SolveStop::converged) << describe(report.stop);
    EXPECT_LT(report.iterations, left > 1e-3 ? 7 : 30);
    return matrix.products - before;
  };
  EXPECT_EQ(productsOf(0.1), 0) << "the first is expected to take eight";
  EXPECT_GT(productsOf(0.1), 0);
  EXPECT_EQ(productsOf(1e-8), 0);
}

/// Multigrid is left when its solves have cost as much as factors would have, with those of the first matrix.
TEST(EquilibriumChoice, DearSolvesByMultigridPayForFactors) {
  SolverCosts costs;
  costs.iteration = 1e-3, costs.setup = 0.01, costs.first = 0.07, costs.with_factors = 0.01;
  const auto solvesUntilDear = [&](int iterations, bool has_patches) {
    EquilibriumChoice choice;
    choice.keeps_factors = true;
    int solves = 1;
    while (solves < 1000 && !choice.isDear(costs, iterations, has_patches, false)) ++solves;
    return solves;
  };
  EXPECT_EQ(solvesUntilDear(10, false), 1000);
  EXPECT_NEAR(solvesUntilDear(30, false), 0.0805 / (0.030 - 0.0115), 1);
  EXPECT_EQ(solvesUntilDear(15, true), solvesUntilDear(30, false));
  EquilibriumChoice exact;
  EXPECT_FALSE(exact.isDear(costs, 100000, false, false)) << "factors of each matrix have no such price";
  EXPECT_LT(solvesUntilDear(1000, false), 1000);
  costs.factor_entries = 1e15;
  EXPECT_EQ(solvesUntilDear(1000, false), 1000) << "factors that do not fit into the memory";
}

/// What former factors leave when they have cost enough is not thrown away where Newton's method has asked for no more.
TEST(EquilibriumChoice, WhatIsGoodEnoughForNewtonsMethodIsKept) {
  const auto isKept = [](SolveStop stop, double left, double asked) {
    SolveReport report;
    report.stop = stop, report.relative_residual = left;
    EquilibriumChoice::acceptEnough(asked, report);
    return report.stop == SolveStop::converged;
  };
  EXPECT_TRUE(isKept(SolveStop::iteration_limit, 3e-4, 0.1));
  EXPECT_FALSE(isKept(SolveStop::iteration_limit, 3e-4, 1e-4));
  EXPECT_FALSE(isKept(SolveStop::iteration_limit, 0.05, 0.1)) << "loose solves lead astray";
  EXPECT_FALSE(isKept(SolveStop::not_definite, 3e-4, 0.1));
}

/// Iterations with former factors are what these have saved, and a share of what factors of each matrix take. A body that they do not
/// serve pays that share at most.
TEST(FormerFactorAccount, FactorsThatDoNotServeCostLittle) {
  const WarpedFactor::Prices prices{1, 0.05};
  const double one = FormerFactorAccount::ofOne(prices);
  FormerFactorAccount account;
  EXPECT_EQ(account.mostIterations({}), 0) << "nothing is factored so far";
  int tried = 0;
  for (int matrix = 0; matrix < 100; ++matrix) {
    const int most = matrix == 0 ? 0 : account.mostIterations(prices);
    tried += most;
    account.addFormer(most, prices), account.addFactors(true, prices), account.endMatrix(prices);
    EXPECT_LE(account.spent, FormerFactorAccount::worth * (matrix + 1) * one + 1e-9);
  }
  EXPECT_GT(tried, 50);
  FormerFactorAccount served;
  served.addFactors(true, prices), served.endMatrix(prices);
  int before = served.mostIterations(prices);
  for (int matrix = 0; matrix < 5; ++matrix) {
    served.addFormer(4, prices), served.endMatrix(prices);
    EXPECT_GT(served.mostIterations(prices), before) << "what was saved may be spent";
    before = served.mostIterations(prices);
  }
}

/// A run that is taken up again knows by which costs was chosen, wherever its nodes are by then.
TEST(AutomaticLinearSolver, CostsOfTheChoiceStay) {
  StoredMatrix matrix = matrixOf(box(16, 16, 16));
  SolverInScene first("<AutomaticLinearSolver/>"), second("<AutomaticLinearSolver/>");
  Vector x;
  first.solve(matrix, weight(box(16, 16, 16)), x);
  for (Vec3& node : matrix.nodes) node.x() *= 1.3;
  handOver(first, second, matrix);
  EXPECT_EQ(second.solver->data().find("choice")->print(), first.solver->data().find("choice")->print());
  SolverCosts costs, again;
  costs.first = 1, costs.with_factors = 2, costs.factor_entries = 3, costs.setup = 4, costs.iteration = 5;
  Archive written;
  written.enter("solver"), costs.serialize(written);
  Archive reading = written.readable();
  reading.enter("solver"), again.serialize(reading);
  for (double SolverCosts::*each : {&SolverCosts::first, &SolverCosts::with_factors, &SolverCosts::factor_entries, &SolverCosts::setup,
                                    &SolverCosts::iteration})
    EXPECT_EQ(again.*each, costs.*each);
}

/// Loose solves that lead to matrices that are not definite are made strict; strict ones that do so too are given up.
TEST(EquilibriumChoice, SolvesAreStrictWhereLooseOnesLeadAstray) {
  SolveReport good, bad;
  bad.stop = SolveStop::not_definite;
  EquilibriumChoice choice;
  choice.noteDefinite(bad);
  EXPECT_FALSE(choice.is_strict) << "no solve has led there";
  choice.noteDefinite(good), choice.noteDefinite(bad);
  EXPECT_TRUE(choice.is_strict);
  for (int k = 0; k < 9; ++k) choice.noteDefinite(bad);
  EXPECT_TRUE(choice.is_strict) << "all of one way astray";
  for (int k = 0; k < 3; ++k) choice.noteDefinite(good), choice.noteDefinite(bad);
  EXPECT_FALSE(choice.is_strict);
}

}  // namespace
}  // namespace stroma::test
