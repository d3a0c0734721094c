// SPDX-License-Identifier: LGPL-2.1-or-later
// Rods of rigid frames, written in units from a nanometre to a million kilometres. Residuals are forces and torques, whose sizes go
// apart with the unit of length: what solvers by products find must not.
#include <fmt/format.h>

#include <algorithm>

#include "tests/iterative_solvers/block_problem.h"
#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// A cantilever of ten beams, one unit of `size` long, after a step under a force or a torque at its end.
std::vector<Vec3> bent(const std::string& integrator, const std::string& solver, double size, bool torque, double load = 1e-3) {
  const double radius = 0.05 * size, young = 1e6, force = load * young * radius * radius * radius * radius / (size * size);
  std::string frames, edges;
  for (int i = 0; i <= 10; ++i) frames += fmt::format("{:.17g} 0 0 0 0 0 1  ", size * i / 10);
  for (int i = 0; i < 10; ++i) edges += fmt::format("{} {}  ", i, i + 1);
  Simulation simulation = simulationFromText(fmt::format(
      R"(<Node name="root" dt="1" gravity="0 0 0"><{} name="integrator"/><{}/><MeshTopology edges="{}"/><MechanicalObject
  template="Rigid3" position="{}"/><UniformMass totalMass="{:.17g}"/><BeamFEMForceField radius="{:.17g}" youngModulus="{}"
  poissonRatio="0.3"/><FixedProjectiveConstraint indices="0"/><ConstantForceField indices="10" forces="0 {:.17g} 0 0 {:.17g} 0"/></Node>)",
      integrator, solver, edges, frames, 1e-12 * young * size, radius, young, torque ? 0 : force, torque ? force * size : 0));
  const StepReport report = simulation.step();
  EXPECT_TRUE(!report.failed() && report.newton_converged) << size << " " << solver << " " << report.reason;
  std::vector<Vec3> way;
  const ConstRows x = simulation.systems()[0]->x;
  for (Index i = 0; i < x.count; ++i)
    way.push_back(i % 2 == 1 ? Vec3(x[i]) : Vec3((x[i] - Vec3(size * (i / 2) / 10, 0, 0)) / size));
  return way;
}

double largestOf(const std::vector<Vec3>& ways, std::size_t first) {
  double most = 0;
  for (std::size_t i = first; i < ways.size(); i += 2) most = std::max(most, ways[i].norm());
  return most;
}

TEST(FramesInAnyUnit, SolversByProductsFindWhatFactorsDo) {
  for (const double size : {1e-9, 1e-6, 1., 1e6, 1e9})
    for (const bool torque : {false, true}) {
      const std::vector<Vec3> expected = bent("EulerImplicitSolver", "SparseLDLSolver", size, torque);
      for (const std::string solver : {"CGLinearSolver", "CGLinearSolver preconditioner=\"none\"", "PCGLinearSolver",
                                       "PCGLinearSolver preconditioner=\"block_jacobi\"", "MinResLinearSolver tolerance=\"1e-12\""}) {
        std::vector<Vec3> off = bent("EulerImplicitSolver", solver, size, torque);
        for (std::size_t i = 0; i < off.size(); ++i) off[i] -= expected[i];
        for (const std::size_t kind : {0, 1})  // places, turns
          EXPECT_LT(largestOf(off, kind), 1e-5 * largestOf(expected, kind)) << size << " " << torque << solver << kind;
      }
    }
}

/// A torque is no sign of a body that nothing holds, however large its number is beside those of forces; and the residual that ends
/// Newton's method has both. The end turns by a few degrees, so that one iteration is not enough.
TEST(FramesInAnyUnit, StaticsFindTheSameShape) {
  for (const bool torque : {false, true}) {
    const std::vector<Vec3> expected = bent("StaticSolver", "SparseLDLSolver", 1, torque, 0.1);
    for (const double size : {1e-9, 1e-6, 1e3, 1e6, 1e9})
      for (const std::string solver : {"SparseLDLSolver", "CGLinearSolver", "MinResLinearSolver"}) {
        std::vector<Vec3> off = bent("StaticSolver", solver, size, torque, 0.1);
        for (std::size_t i = 0; i < off.size(); ++i) off[i] -= expected[i];
        for (const std::size_t kind : {0, 1})
          EXPECT_LT(largestOf(off, kind), 1e-7 * largestOf(expected, kind)) << size << torque << solver << kind;
      }
  }
}

// ---- rows of another unit in matrices that no component made ----

/// A becomes T A T and b T b, with `unit` in T at each 50th row and 1 elsewhere, as if these rows were turns.
std::vector<double> takeOtherUnits(StoredMatrix& matrix, Vector& b, double unit) {
  std::vector<double> units(std::size_t(matrix.rows()), 1.);
  for (std::size_t i = 49; i < units.size(); i += 50) units[i] = unit;
  BlockMatrix& a = matrix.values;
  for (Index row = 0; row < a.rows(); ++row)
    for (Index s = a.rowStart()[row]; s < a.rowStart()[row + 1]; ++s)
      for (int k = 0; k < 9; ++k) a.values()[std::size_t(9 * s + k)] *= units[std::size_t(row)] * units[std::size_t(a.columns()[s])];
  for (Index row = 0; row < b.count(); ++row) b[row] *= units[std::size_t(row)];
  matrix.has_turns = true;
  return units;
}

/// |S (b - A x)| / |S b|, S of the diagonal blocks.
double leftOver(const StoredMatrix& matrix, ConstRows b, ConstRows x) {
  Vector r(b.count);
  matrix.multiply(x, r);
  std::vector<double> blocks;
  matrix.diagonalBlocks(blocks);
  double left = 0, all = 0;
  for (Index row = 0; row < b.count; ++row) {
    const double* const block = blocks.data() + 9 * std::size_t(row);
    const double size = block[0] + block[4] + block[8];
    left += (b[row] - r[row]).squaredNorm() / size, all += b[row].squaredNorm() / size;
  }
  return std::sqrt(left / all);
}

/// 4,913 nodes are solved by products with a multigrid, by conjugate gradients or GMRES. In large units and under loads on these rows
/// alone all other residuals are large numbers beside those that count, which must not keep a solve from its end.
TEST(FramesInAnyUnit, RowsOfAnotherUnitAreSolvedAsWell) {
  struct Case {
    std::string solver;
    Index cells;
    bool is_symmetric;
  };
  for (const Case& each : {Case{"<MinResLinearSolver/>", 6, true}, Case{"<AutomaticLinearSolver/>", 16, true},
                           Case{"<AutomaticLinearSolver/>", 16, false}})
    for (const double unit : {1e-9, 1e-6, 1e6}) {
      const bool has_loads_there_alone = unit == 1e-9;
      const ElasticBlock block = box(each.cells, each.cells, each.cells);
      StoredMatrix plain = matrixOf(block), matrix = matrixOf(block);
      plain.is_symmetric = matrix.is_symmetric = each.is_symmetric;
      Vector b = weight(block), expected, x;
      for (Index row = 0; row < b.count() && has_loads_there_alone; ++row)
        if (row % 50 != 49) b[row] = Vec3::Zero();
      SolverInScene first(each.solver), second(each.solver);
      const SolveReport before = first.solve(plain, b, expected);
      ASSERT_EQ(before.stop, SolveStop::converged) << each.solver;
      const std::vector<double> units = takeOtherUnits(matrix, b, unit);
      const SolveReport report = second.solve(matrix, b, x);
      EXPECT_EQ(report.stop, SolveStop::converged) << each.solver << unit;
      const double left = leftOver(matrix, b, x);
      std::printf("%s%s unit %g: %d iterations, %d without it, left %.2g by the diagonal\n", each.solver.c_str(),
                  each.is_symmetric ? "" : ", unsymmetric", unit, report.iterations, before.iterations, left);
      const Data* const choice = second.solver->data().find("choice");
      EXPECT_TRUE(!choice || unit > 1 || choice->print().find("with multigrid: ") != std::string::npos) << choice->print();
      const bool is_by_multigrid = each.cells > 10 && each.is_symmetric;  // which measures otherwise
      EXPECT_LT(left, is_by_multigrid ? 1e-7 : 1.2e-8) << each.solver << unit;
      double off = 0;
      for (Index row = 0; row < x.count(); ++row) off = std::max(off, (units[std::size_t(row)] * x[row] - expected[row]).norm());
      EXPECT_LT(off, 1e-5 * largest(expected)) << each.solver << each.is_symmetric << unit;
    }
}

/// A force whose square over the stiffness is no number is measured as it is: what needs that square breaks down and says so.
TEST(FramesInAnyUnit, ForcesNearTheSmallestNumberHaveASize) {
  const ElasticBlock block = box(3, 3, 3);
  for (const std::string solver :
       {"<CGLinearSolver/>", "<CGLinearSolver preconditioner='none'/>", "<PCGLinearSolver preconditioner='block_jacobi'/>"}) {
    StoredMatrix matrix = matrixOf(block);
    for (double& value : matrix.values.values()) value *= 1e30;
    matrix.has_turns = true;
    Vector b = weight(block), x;
    SolverInScene inScene(solver);
    ASSERT_EQ(inScene.solve(matrix, b, x).stop, SolveStop::converged);
    Vector expected(x.count());
    copy(x, expected);
    scale(1e-155, b), scale(1e-155, expected), clear(x);
    const SolveReport report = SolverInScene(solver).solve(matrix, b, x);
    EXPECT_TRUE(std::isfinite(report.relative_residual)) << solver;
    const bool is_plain = solver.find("none") != std::string::npos;
    EXPECT_EQ(report.stop, is_plain ? SolveStop::converged : SolveStop::breakdown) << solver << describe(report.stop);
    if (!is_plain) continue;
    for (Index row = 0; row < x.count(); ++row) EXPECT_LT((x[row] - expected[row]).norm(), 1e-6 * largest(expected)) << solver << row;
  }
}

/// What follows iterations that are given up, factors here, is measured in its own way again.
TEST(FramesInAnyUnit, FactorsAfterIterationsTellTheirOwnResidual) {
  ElasticBlock block = box(7, 7, 7);
  block.poisson = 0.499999, block.young = 1e12;
  StoredMatrix matrix = matrixOf(block);
  matrix.has_turns = true;
  const Vector b = weight(block);
  SolverInScene solver("<PCGLinearSolver tolerance='1e-16'/>");
  Vector x, r(b.count());
  for (int solve = 0; solve < 3; ++solve) {
    clear(x);
    const SolveReport report = solver.solve(matrix, b, x);
    matrix.multiply(x, r);
    EXPECT_NEAR(report.relative_residual / (distance(r, b) / norm(b)), 1, 0.5) << solve << describe(report.stop)
        << solver.solver->data().find("choice")->print();
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
