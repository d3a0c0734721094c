// SPDX-License-Identifier: LGPL-2.1-or-later
// What the estimates of SolverCosts say beside processor time, part by part. They decide by their ratios, so what counts is that all
// parts are off by the same factor: that of the machine.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <ctime>
#include <functional>

#include "components/iterative_solvers/preconditioner.h"
#include "components/iterative_solvers/solver_costs.h"
#include "framework/algebra/direct_solver.h"
#include "framework/simulation/simulation.h"
#include "tests/support/solver_fixture.h"

namespace stroma::test {
namespace {

/// Processor time [ns], the least of five times; `prepare` does not count.
double nanoseconds(const std::function<void()>& work, const std::function<void()>& prepare = [] {}) {
  double least = 1e300;
  for (int k = 0; k < 5; ++k) {
    prepare();
    timespec before{}, after{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &before);
    work();
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &after);
    least = std::min(least, 1e9 * double(after.tv_sec - before.tv_sec) + double(after.tv_nsec - before.tv_nsec));
  }
  return least;
}

std::string bodyOf(const std::string& n, const std::string& size, bool tetrahedra) {
  const std::string field = tetrahedra ? "Tetrahedron" : "Hexahedron";
  return "<Node name=\"root\" dt=\"0.01\" gravity=\"0 -9.81 0\"><EulerImplicitSolver/><SparseLDLSolver/>"
         "<RegularGridTopology name=\"grid\" n=\"" + n + "\" min=\"0 0 0\" max=\"" + size + "\"/><MechanicalObject name=\"dofs\"/>" +
         (tetrahedra ? "<TetrahedronSetTopologyContainer name=\"cells\"/><Hexa2TetraTopologicalMapping input=\"@grid\" "
                       "output=\"@cells\" cutting=\"five\"/>" : "") +
         "<DiagonalMass massDensity=\"1000\"" + (tetrahedra ? " topology=\"@cells\"" : "") + "/><" + field +
         "FEMForceField youngModulus=\"3e5\" poissonRatio=\"0.4\" method=\"" + (tetrahedra ? "svd\" topology=\"@cells" : "polar") +
         "\"/><BoxROI name=\"wall\" box=\"-1 -1 -1 0.0001 1 1\"/><FixedProjectiveConstraint indices=\"@wall.indices\"/></Node>";
}

void compare(const char* name, const std::string& text) {
  Simulation simulation = simulationFromText(text);
  System& system = *simulation.systems().front();
  MechanicalMatrix& matrix = system.matrix();
  int calls = 0;
  const auto assemble = [&] {
    matrix.withFactors({.mass = 1, .stiffness = -1e-4 * (1 + 1e-6 * ++calls)});
    matrix.assemble();
  };
  assemble();
  const BlockMatrix& a = matrix.assemble();
  const double rows = a.rows(), blocks = a.blocks();
  const auto say = [&](const char* part, double estimated, double measured) {
    fmt::print("| {} | {} | {:.3f} | {:.3f} | {:.2f} |\n", name, part, 1e-6 * estimated, 1e-6 * measured, estimated / measured);
    EXPECT_GT(estimated, 0) << name << ", " << part;
  };
  say("assembly", IterationCosts::assembly(matrix), nanoseconds(assemble));
  SolveReport report;
  const Scene multigrid = sceneFromText("<Node name=\"root\"><MultigridPreconditioner/></Node>");
  std::vector<Preconditioner*> found;
  multigrid.root->collect(found);
  const std::unique_ptr<ApproximateInverse> hierarchy = found.at(0)->makeInverse();
  say("hierarchy", IterationCosts::hierarchy(rows, blocks), nanoseconds([&] {
        hierarchy->reset();
        EXPECT_TRUE(hierarchy->follow(matrix, report, {}));
      }));
  const Vector b = randomVector(a.rows(), 1);
  Vector x(a.rows());
  say("cycle", IterationCosts::cycle(rows, blocks), nanoseconds([&] { hierarchy->apply(b, x); }));
  say("product", BlockMatrix::productCost(blocks, false), nanoseconds([&] { a.multiply(b, x); }));
  const FactorCosts costs =
      factorCosts(rows, blocks, fewest(a, dissected(blocks, countFactors(a)), extentsOf(a.rows(), matrix.positions())));
  std::unique_ptr<SolverInScene> fresh;
  Factorisation* factors = nullptr;
  const double first = nanoseconds([&] { factors = dynamic_cast<DirectSolver&>(*fresh->solver).factor(matrix, report, {}); },
                                   [&] { fresh = std::make_unique<SolverInScene>("<SparseLDLSolver/>"); });
  ASSERT_TRUE(factors);
  Index row = -1;
  const double factor = nanoseconds([&] {
    factors->load(a);
    EXPECT_EQ(factors->factor(row, {}), SolveStop::converged);
  });
  say("order", costs.order, first - factor);
  say("factor", costs.factor, factor);
  say("application", costs.application - FactorCosts::turning * rows, nanoseconds([&] { factors->applyRoughly(b, x); }));
}

TEST(SolverCosts, EstimatesBesideProcessorTime) {
  fmt::print("| body | part | estimated [ms] | measured [ms] | ratio |\n|---|---|---|---|---|\n");
  compare("cube of tetrahedra, 4,913 nodes", bodyOf("17 17 17", "0.1 0.1 0.1", true));
  compare("bar of tetrahedra, 3,321 nodes", bodyOf("41 9 9", "0.2 0.04 0.04", true));
  compare("cube of hexahedra, 4,913 nodes", bodyOf("17 17 17", "0.1 0.1 0.1", false));
}

}  // namespace
}  // namespace stroma::test
