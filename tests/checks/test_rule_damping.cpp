// SPDX-License-Identifier: LGPL-2.1-or-later
// What backward Euler takes from a swing is said, as much as it takes; and nothing where it takes little, or nobody swings.
#include <fmt/format.h>

#include <numbers>

#include "tests/support/scene_fixture.h"
#include "tools/checks/rule_damping.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// 1 kg on a spring with a period of 1 s, let go 0.1 m from its rest.
std::string oscillator(const std::string& integrator, double dt, const std::string& start = "0.1 0 0") {
  return fmt::format(R"(<Node name="root" dt="{}" gravity="0 0 0">{}<SparseLDLSolver/>
    <MechanicalObject name="dofs" rest_position="0 0 0" position="{}"/><UniformMass totalMass="1"/>
    <RestShapeSpringsForceField points="0" stiffness="{}"/></Node>)",
                     dt, integrator, start, 4 * std::numbers::pi * std::numbers::pi);
}

struct Swung {
  std::string said;
  double lost;  ///< between the heights of two swings a period apart
};

Swung swing(const std::string& text, int steps) {
  Simulation simulation = simulationFromText(text);
  double first = 0, second = 0;
  for (int step = 0; step < steps; ++step) {
    simulation.step();
    const double x = simulation.systems()[0]->x[0].x();
    double& height = simulation.time() < 1.3 ? first : second;
    if (simulation.time() > 0.7) height = std::max(height, x);
  }
  const std::vector<std::string> sentences = dampedSwings(simulation);
  return {sentences.empty() ? "" : sentences[0], 1 - second / first};
}

TEST(RuleDamping, IsSaidAsMuchAsItTakes) {
  for (const auto& [dt, percent] : {std::pair(0.01, 18), std::pair(0.004, 8), std::pair(0.03, 44)}) {
    const Swung found = swing(oscillator("<EulerImplicitSolver/>", dt), int(2.1 / dt));
    EXPECT_NEAR(100 * found.lost, percent, 1) << "what the steps show";
    expectContains(found.said, fmt::format("loses {} % of its amplitude per period", percent));
    expectContains(found.said, "/EulerImplicitSolver at t = ");
  }
}

TEST(RuleDamping, IsNotSaidWhereThereIsNone) {
  for (const auto& [integrator, dt] :
       {std::pair("<EulerImplicitSolver trapezoidalScheme='true'/>", 0.01), std::pair("<NewmarkImplicitSolver/>", 0.01),
        std::pair("<EulerImplicitSolver/>", 0.001), std::pair("<EulerImplicitSolver rayleighStiffness='0.2'/>", 0.01)})
    EXPECT_EQ(swing(oscillator(integrator, dt), int(0.6 / dt)).said, "") << integrator;
  EXPECT_EQ(swing(oscillator("<EulerImplicitSolver/>", 0.01, "0 0 0"), 60).said, "") << "at rest";
  EXPECT_EQ(swing(oscillator("<EulerImplicitSolver/>", 0.01), 20).said, "") << "no swing yet";
  const std::string driven = "<LinearMovementProjectiveConstraint indices='0' keyTimes='0 10' movements='0 0 0 1 0 0'/></Node>";
  std::string moved = oscillator("<EulerImplicitSolver/>", 0.01);
  moved.replace(moved.rfind("</Node>"), 7, driven);
  EXPECT_EQ(swing(moved, 60).said, "") << "what is driven at constant speed";
  Simulation falling = simulationFromText(
      R"(<Node dt="0.01" gravity="0 -9.81 0"><EulerImplicitSolver/><CGLinearSolver/><MechanicalObject position="0 0 0"/>
      <UniformMass totalMass="1"/></Node>)");
  for (int step = 0; step < 10; ++step) falling.step();
  EXPECT_TRUE(dampedSwings(falling).empty()) << "a fall is no swing";
}

/// From the shape of rest under a constant push: the way is the shape of the only swing, whose period is 1 s.
TEST(RuleDamping, StepsThatSkipTheSlowestSwingAreNamed) {
  const auto pushed = [](double dt, const std::string& integrator) {
    std::string text = oscillator(integrator, dt, "0 0 0");
    text.replace(text.rfind("</Node>"), 7, "<ConstantForceField indices='0' forces='1 0 0'/></Node>");
    return swing(text, 20).said;
  };
  expectContains(pushed(10, "<EulerImplicitSolver/>"), "is 10 periods of the slowest oscillation, of 1");
  EXPECT_EQ(pushed(0.5, "<EulerImplicitSolver/>").find("periods"), std::string::npos);
  EXPECT_EQ(pushed(10, "<StaticSolver/>"), "");
}

/// A ball that comes to where a body was at its start would have no bound on its energy there; one that pushes is no swing.
TEST(RuleDamping, WhatIsPushedAsideIsNoSwing) {
  for (const char* contact : {"BarrierContact", "PenaltyContact"}) {
    const std::string text = fmt::format(
        R"(<Node name="root" dt="0.01" gravity="0 0 0"><EulerImplicitSolver newtonIterations="60"/><SparseLDLSolver/>
        <MeshTopology position="0 0 0  1 0 0  0 1 0  0 0 1" tetrahedra="0 1 2 3"/><MechanicalObject/><UniformMass totalMass="1"/>
        <RestShapeSpringsForceField points="0 1 2 3" stiffness="40"/><TetrahedronFEMForceField youngModulus="1000"
        poissonRatio="0.3"/><{} contactDistance="0.05" spheres="-0.6 0.3 0.3 0.5" keyTimes="0 0.3" movements="0 0 0  0.3 0 0"
        selfContact="false" stiffness="1000"/></Node>)",
        contact);
    EXPECT_EQ(swing(text, 30).said, "") << contact;
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
