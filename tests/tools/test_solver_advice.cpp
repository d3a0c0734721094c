// SPDX-License-Identifier: LGPL-2.1-or-later
// What is said of solvers, tangents and forcing terms that a scene names, beside the processor time that the run takes without them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <ctime>

#include "framework/algebra/parallel.h"
#include "framework/simulation/system.h"
#include "tools/command/solver_advice.h"
#include "tools/session/session.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// A bar of five tetrahedra per cell that is held at one end under its weight.
struct Bar {
  std::string nodes = "9 9 9", size = "0.1 0.1 0.1", integrator = "<StaticSolver/>", solver, field = R"(method="svd")";
  double young = 1e5, dt = 1;
  std::string text() const {
    return fmt::format(R"(<Node name="root" dt="{}" gravity="0 -9.81 0">{}{}
  <RegularGridTopology name="grid" n="{}" min="0 0 0" max="{}"/><MechanicalObject name="dofs"/><DiagonalMass massDensity="1000"/>
  <BoxROI name="wall" box="-1 -1 -1 0.0001 1 1"/><FixedProjectiveConstraint indices="@wall.indices"/>
  <Node name="cells"><TetrahedronSetTopologyContainer name="t"/>
    <Hexa2TetraTopologicalMapping input="@../grid" output="@t" cutting="five"/>
    <TetrahedronFEMForceField name="fem" mstate="@../dofs" topology="@t" youngModulus="{}" poissonRatio="0.4" {}/></Node></Node>)",
                       dt, integrator, solver, nodes, size, young, field);
  }
};

struct Made {
  double seconds = 0, iterations = 0;
  std::vector<std::string> advice;
};

/// As if solves had taken two seconds, on whatever machine.
Made made(const Bar& bar, long steps) {
  setThreads(1);
  Session session;
  Simulation& simulation = session.loadText(bar.text(), "bar.xml");
  const std::clock_t begin = std::clock();
  const RunReport report = session.run({.steps = steps});
  EXPECT_EQ(report.end, RunEnd::done) << report.reason;
  const double seconds = double(std::clock() - begin) / CLOCKS_PER_SEC;
  for (const auto& system : simulation.systems()) system->times.solve = 2;
  return {seconds, double(report.statistics.linear_iterations), command::solverAdvice(simulation, report.statistics)};
}

double timesIn(const std::string& sentence, const std::string& before) {
  const auto at = sentence.find(before);
  return at == std::string::npos ? 0 : std::atof(sentence.c_str() + at + before.size());
}

/// The ratio is that of the model, which is right within a factor of three here.
void expectTrue(const Bar& named, const Bar& free, long steps, const std::string& without) {
  const Made one = made(named, steps), other = made(free, steps);
  EXPECT_TRUE(other.advice.empty()) << other.advice[0];
  ASSERT_EQ(one.advice.size(), 1u) << without << " took " << one.seconds / other.seconds << " times as long";
  EXPECT_NE(one.advice[0].find(without), std::string::npos) << one.advice[0];
  const double told = timesIn(one.advice[0], "estimated at "), measured = one.seconds / other.seconds;
  std::printf("%s: %.1f times measured\n", one.advice[0].c_str(), measured);
  EXPECT_GT(measured, told / 3) << one.advice[0];
  EXPECT_LT(measured, told * 3) << one.advice[0];
}

TEST(SolverAdvice, FactorsOfALargeBody) {
  Bar free{.nodes = "27 27 27", .field = R"(method="small")"}, named = free;
  named.solver = "<SparseLDLSolver/>";
  expectTrue(named, free, 1, "without <SparseLDLSolver> the run chooses the solver");
}

TEST(SolverAdvice, ConjugateGradientsOfABeam) {
  Bar free{.nodes = "81 5 5", .size = "0.8 0.04 0.04", .integrator = "<EulerImplicitSolver/>", .young = 1e8, .dt = 0.05}, named = free;
  named.solver = "<CGLinearSolver/>";
  expectTrue(named, free, 12, "without <CGLinearSolver> the run chooses the preconditioner");
}

TEST(SolverAdvice, APreconditionerOfABodyOf700Nodes) {
  Bar free{.nodes = "41 4 4", .size = "0.8 0.06 0.06", .integrator = "<EulerImplicitSolver/>", .young = 1e8, .dt = 0.1}, named = free;
  named.solver = R"(<PCGLinearSolver preconditioner="block_jacobi"/>)";
  expectTrue(named, free, 40, "without preconditioner=\"block_jacobi\" it chooses one");
}

TEST(SolverAdvice, MultigridOfABodyWithOneMatrix) {
  Bar free{.nodes = "101 4 4", .size = "1 0.03 0.03", .integrator = "<EulerImplicitSolver/>", .field = R"(method="small")", .young = 1e8,
           .dt = 0.05};
  Bar named = free;
  named.solver = R"(<PCGLinearSolver preconditioner="multigrid"/>)";
  expectTrue(named, free, 150, "without preconditioner=\"multigrid\" it chooses one");
}

TEST(SolverAdvice, NoneOfSolversThatSuit) {
  const std::string euler = "<EulerImplicitSolver/>";
  const Bar few{.nodes = "6 6 6", .integrator = euler, .solver = "<SparseLDLSolver/>", .dt = 0.01};
  const Bar light{.nodes = "15 15 15", .integrator = euler, .solver = R"(<PCGLinearSolver preconditioner="block_jacobi"/>)", .dt = 0.002};
  const Bar large{.nodes = "21 21 21", .solver = R"(<PCGLinearSolver preconditioner="multigrid"/>)", .field = R"(method="small")"};
  for (const Bar& bar : {few, light, large})
    for (const std::string& advice : made(bar, bar.dt < 1 ? 10 : 1).advice) ADD_FAILURE() << advice;
}

TEST(SolverAdvice, AForcingTermOfZero) {
  Bar free{.nodes = "21 21 21", .young = 3e4}, named = free;
  named.integrator = R"(<StaticSolver forcing_term="0"/>)";
  const Made one = made(named, 1), other = made(free, 1);
  EXPECT_TRUE(other.advice.empty());
  ASSERT_EQ(one.advice.size(), 1u);
  EXPECT_NE(one.advice[0].find("each to forcing_term=\"0\" of /StaticSolver"), std::string::npos) << one.advice[0];
  const double told = timesIn(one.advice[0], "is estimated to take ");
  const double measured = one.iterations / other.iterations;
  std::printf("%s: %.1f times measured, and %.1f times the seconds\n", one.advice[0].c_str(), measured, one.seconds / other.seconds);
  EXPECT_GT(measured, told / 2) << one.advice[0];
  EXPECT_LT(measured, told * 2) << one.advice[0];
  EXPECT_GT(one.seconds, 1.2 * other.seconds);
}

TEST(SolverAdvice, AWarpedTangentThatTakesManyIterations) {
  Bar free{.nodes = "13 13 13", .size = "0.3 0.3 0.3", .young = 15e3}, named = free;
  named.field = R"(method="svd" tangent="warped")";
  const Made one = made(named, 1), other = made(free, 1);
  EXPECT_TRUE(other.advice.empty());
  ASSERT_EQ(one.advice.size(), 1u) << one.seconds / other.seconds;
  EXPECT_NE(one.advice[0].find("iterations per step with tangent=\"warped\" of /cells/fem"), std::string::npos) << one.advice[0];
  EXPECT_GT(one.seconds, 1.2 * other.seconds) << one.advice[0];
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
