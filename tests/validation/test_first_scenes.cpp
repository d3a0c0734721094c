// SPDX-License-Identifier: LGPL-2.1-or-later
// The scenes that a new user writes first: a beam that sags under its weight, in time and in statics, with the line of a
// linear solver copied from a SOFA file, with one that says nothing, and with none. They must give the answer of a
// direct solver, or say that they do not.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/support/scene_fixture.h"
#include "tools/plan/plan.h"
#include "tools/session/statistics.h"

using namespace stroma;
using namespace stroma::test;

namespace {

/// A clamped beam of length 1 m, `across` wide and high, of cubes with half that edge.
std::string beam(const std::string& solvers, double across) {
  return fmt::format(
      R"(<Node name="root" dt="0.05" gravity="0 -1 0">
  {}
  <RegularGridTopology name="grid" n="{} 3 3" min="0 0 0" max="1 {} {}"/>
  <MechanicalObject/>
  <UniformMass totalMass="{}"/>
  <BoxROI name="wall" box="-0.01 -1 -1  0.001 1 1"/><FixedProjectiveConstraint indices="@wall.indices"/>
  <HexahedronFEMForceField youngModulus="1e6" poissonRatio="0.3" method="polar"/></Node>)",
      solvers, int(std::lround(2 / across)) + 1, across, across, 1000 * across * across);
}

struct Sag {
  double tip = 0;  ///< deflection of the last node [m]
  bool converged = true;
};

Sag sagOf(const std::string& solvers, double across, int steps) {
  Simulation simulation = simulationFromText(beam(solvers, across));
  RunStatistics statistics;
  for (int i = 0; i < steps; ++i) statistics.add(simulation.step(), 0);
  const State& body = *simulation.states().front();
  const Index last = body.size() - 1;
  return {body.rest_position[last][1] - body.x()[last][1], statistics.unconverged.none()};
}

double rightSag(double across) {
  const Sag sag = sagOf("<StaticSolver/><SparseLDLSolver/>", across, 1);
  EXPECT_TRUE(sag.converged);
  return sag.tip;
}

const std::string in_time = "<EulerImplicitSolver rayleighMass='2' rayleighStiffness='0.02'/>";
const std::vector<std::string> uncapped{"", "<CGLinearSolver/>", "<PCGLinearSolver/>", "<MinResLinearSolver/>"};
const std::string from_sofa = "<CGLinearSolver iterations='25' tolerance='1e-9' threshold='1e-9'/>";

}  // namespace

TEST(FirstScenes, ABeamComesToRestWhereADirectSolverPutsIt) {
  for (const double across : {0.1, 0.04}) {
    const double right = rightSag(across);
    ASSERT_GT(right, 0.001);
    for (const std::string& solver : uncapped) {
      const Sag sag = sagOf(in_time + solver, across, 400);
      EXPECT_TRUE(sag.converged) << solver;
      EXPECT_NEAR(sag.tip, right, 0.01 * right) << solver << " " << across;
    }
  }
}

TEST(FirstScenes, StaticsIsRightWithAnySolverThatNothingCaps) {
  for (const double across : {0.1, 0.04}) {
    const double right = rightSag(across);
    for (const std::string& solver : uncapped) {
      const Sag sag = sagOf("<StaticSolver/>" + solver, across, 1);
      EXPECT_TRUE(sag.converged) << solver;
      EXPECT_NEAR(sag.tip, right, 1e-6 * right) << solver << " " << across;
    }
  }
}

TEST(FirstScenes, ACapThatASceneWritesHoldsAndIsToldOf) {
  const double right = rightSag(0.04);
  const Sag sag = sagOf(in_time + from_sofa, 0.04, 400);
  EXPECT_FALSE(sag.converged);
  EXPECT_GT(std::abs(sag.tip - right), 0.01 * right) << "a cap that does no harm tests nothing";
  Simulation simulation = simulationFromText(beam(in_time + from_sofa, 0.04));
  EXPECT_EQ(simulation.step().linear_iterations, 25);
}

TEST(FirstScenes, ASolverThatIsMadeIsSaidByThePlan) {
  const auto linesOf = [](const std::string& solvers) {
    std::string lines;
    for (const std::string& line : planOf(simulationFromText(beam(solvers, 0.1))).lines()) lines += line + "\n";
    return lines;
  };
  EXPECT_NE(linesOf(in_time).find("PCGLinearSolver, created"), std::string::npos);
  EXPECT_NE(linesOf("<StaticSolver/>").find("AutomaticLinearSolver, created"), std::string::npos);
  EXPECT_EQ(linesOf("<EulerExplicitSolver/>").find("LinearSolver"), std::string::npos);
}
