// SPDX-License-Identifier: LGPL-2.1-or-later
// Lagrangian constraints and contact on condensed bodies. EulerImplicitSolver has the equations of CondensedDynamicSolver without
// damping, and solves them by other means: a solve with the whole matrix for each condition. In steps of 1e5 s the inertia is gone
// and it has those of CondensedStaticSolver.
#include <fmt/format.h>

#include "framework/collision/pair_distances.h"
#include "framework/mechanics/state_topology.h"
#include "tests/condensation/bodies.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

const std::string whole = "<EulerImplicitSolver/><SparseLDLSolver/>";

/// A sphere that is pressed 4 mm into the side of the block and moved along it, in ten steps.
std::string sphere(double dt, double friction) {
  return fmt::format(
      "<ConstraintContact name=\"contact\" spheres=\"0.105 0.033 0.09 0.024\" keyTimes=\"0 {} {}\" movements=\"0 0 0  -0.005 0 0  "
      "-0.005 0.002 0.003\" contactDistance=\"1e-4\" friction=\"{}\"/>",
      5 * dt, 10 * dt, friction);
}

const std::string joints =
    "<FixedLagrangianConstraint indices=\"139\"/><DistanceLagrangianConstraint first_point=\"120 134\" second_point=\"137 121\" "
    "distances=\"0.065 0.068\"/>";
const std::string dragged =
    "<LinearMovementProjectiveConstraint indices=\"136\" keyTimes=\"0 {0} {1}\" movements=\"0 0 0  0.002 0.001 -0.001  0 0 0\"/>"
    "<FixedPlaneProjectiveConstraint indices=\"60 61\" direction=\"0 1 0\"/>";

TEST(CondensedConditions, ADynamicBodyIsTheWholeBody) {
  constexpr double dt = 0.002;
  for (const double friction : {0.0, 0.4}) {
    SCOPED_TRACE(friction);
    expectWhole(condensed_in_time, whole, {.loads = sphere(dt, friction), .gravity = "0 0 0", .dt = dt}, 10, 1e-7);
  }
  expectWhole(condensed_in_time, whole, {.loads = joints, .dt = dt}, 10, 1e-7);
}

TEST(CondensedConditions, AStaticBodyIsTheWholeBody) {
  constexpr double dt = 1e5;
  for (const double friction : {0.0, 0.4}) {
    SCOPED_TRACE(friction);
    expectWhole(condensed_statics, whole, {.loads = sphere(dt, friction), .gravity = "0 0 0", .dt = dt}, 10, 1e-7);
  }
  expectWhole(condensed_statics, whole, {.loads = joints, .dt = dt}, 4, 1e-7);
}

/// Along one side of the block, pulled from below: it bends.
TEST(CondensedConditions, ACablePullsAsOnTheWholeBody) {
  for (const double dt : {0.002, 1e5}) {
    SCOPED_TRACE(dt);
    Block block{.loads = "<CableConstraint name=\"cable\" indices=\"42 82 122\" pullPoint=\"0.04 -0.02 0\" value=\"0.002\" "
                         "maxDispVariation=\"0.0005\"/>",
                .gravity = "0 0 0",
                .dt = dt};
    dt < 1 ? expectWhole(condensed_in_time, whole, block, 8, 1e-7) : expectWhole(condensed_statics, whole, block, 8, 1e-7);
    double tension = 0;
    for (const std::string& solver : {whole, std::string(dt < 1 ? "<CondensedDynamicSolver/>" : "<CondensedStaticSolver/>")}) {
      block.solver = solver;
      Simulation simulation = simulationFromText(block.text());
      for (int i = 0; i < 8; ++i) simulation.step();
      std::vector<Component*> all;
      simulation.root().collect(all);
      for (const Component* component : all) {
        if (component->name() != "cable") continue;
        const double force = std::stod(component->data().find("force")->print());
        EXPECT_NEAR(std::stod(component->data().find("displacement")->print()), 0.002, 1e-10);
        EXPECT_GT(std::abs(force), 1e-3);
        if (tension == 0) tension = force;
        EXPECT_NEAR(force, tension, 1e-6 * std::abs(tension));
      }
    }
  }
}

TEST(CondensedConditions, NodesThatAreDraggedAreInTheCompliance) {
  for (const double dt : {0.002, 1e5}) {
    const std::string loads = fmt::format(fmt::runtime(dragged), 5 * dt, 20 * dt) + sphere(dt, 0.3) + joints;
    Block block{.loads = loads, .gravity = "0 0 0", .dt = dt};
    dt < 1 ? expectWhole(condensed_in_time, whole, block, 8, 1e-7) : expectWhole(condensed_statics, whole, block, 8, 1e-7);
  }
}

/// Of the whole surface: distances of all its triangles from the centre, by what finds no pairs.
TEST(CondensedConditions, NothingIsInTheSphere) {
  constexpr double dt = 1;
  const Block block{.solver = "<CondensedStaticSolver/>", .loads = sphere(dt, 0.4), .gravity = "0 0 0", .dt = dt};
  Simulation simulation = simulationFromText(block.text());
  const State& state = *simulation.states().back();
  const auto triangles = topologyOf(state)->mesh().boundaryTriangles();
  double nearest = 1;
  for (int step = 1; step <= 10; ++step) {
    const StepReport report = simulation.step();
    ASSERT_TRUE(report.constraints_converged) << report.constraint_reason;
    const Vec3 moved = step <= 5 ? Vec3(-0.001 * step, 0, 0) : Vec3(-0.005, 0.0004 * (step - 5), 0.0006 * (step - 5));
    const Vec3 centre = Vec3(0.105, 0.033, 0.09) + moved;
    for (const Triangle& t : triangles)
      nearest = std::min(
          nearest, closestPoints(PairKind::point_triangle, {centre, state.x()[t[0]], state.x()[t[1]], state.x()[t[2]]}).distance());
  }
  EXPECT_NEAR(nearest, 0.024 + 1e-4, 1e-9);
}

TEST(CondensedConditions, ARunRepeatsBitForBitAlsoFromACheckpoint) {
  std::string slides = sphere(1, 0.4);
  slides.replace(slides.find("-0.005 0.002 0.003"), 18, "-0.005 0.002 0.040").replace(slides.find("keyTimes=\"0 5 10\""), 17,
                                                                                      "keyTimes=\"0 5 20\"");
  const Block block{.solver = "<CondensedStaticSolver/>", .loads = slides, .gravity = "0 0 0", .dt = 1};
  Simulation simulation = simulationFromText(block.text());
  for (int i = 0; i < 20; ++i) simulation.step();  // slides along several cells
  simulation.reset();
  for (int i = 0; i < 20; ++i) simulation.step();
  EXPECT_EQ(difference(displacement(simulation), after(block.text(), 20)), 0);
  Simulation whole_run = simulationFromText(block.text()), restored = simulationFromText(block.text());
  for (int i = 0; i < 12; ++i) whole_run.step();
  restored.restore(whole_run.checkpoint());
  for (int i = 12; i < 20; ++i) whole_run.step(), restored.step();
  EXPECT_EQ(difference(displacement(restored), displacement(whole_run)), 0);
}

/// Barriers too: no matrix of a condensed body has their derivative.
TEST(CondensedConditions, DampingOfBarriersIsRefused) {
  const Block block{.solver = "<CondensedDynamicSolver/>",
                    .loads = "<BarrierContact planes=\"0 0 1 -1\" selfContact=\"false\" rayleighStiffness=\"0.5\"/>"};
  const std::string problems = problemsOf(block.text());
  EXPECT_NE(problems.find("has rayleighStiffness"), std::string::npos) << problems;
}

/// A plane goes a micrometre into nodes that are held: that is a thousandth of the gap, or more than what is written.
TEST(CondensedConditions, ErrorsThatAreToleratedHold) {
  const auto pressed = [](const std::string& solver, const std::string& tolerated) {
    const std::string plane = "<ConstraintContact contactDistance=\"1e-3\" planes=\"0 0 1 -1e-3\" keyTimes=\"0 1\" "
                              "movements=\"0 0 0  0 0 9e-7\" " + tolerated + "/>";
    return simulationFromText(Block{.solver = solver, .loads = plane, .gravity = "0 0 0", .dt = 1}.text()).step();
  };
  for (const std::string& solver : {condensed_statics[0], condensed_statics[1], condensed_in_time[0], whole,
                                    std::string("<StaticSolver/><SparseLDLSolver/>")}) {
    SCOPED_TRACE(solver);
    const StepReport held = pressed(solver, ""), refused = pressed(solver, "toleratedError=\"1e-8\"");
    EXPECT_TRUE(held.constraints_converged) << held.constraint_reason;
    EXPECT_EQ(held.constraint_reason, "");
    EXPECT_FALSE(refused.constraints_converged);
    expectContains(refused.constraint_reason, "a condition is off by 9e-07");
  }
}

TEST(CondensedConditions, OnInsideNodesAreToldWithTheNode) {
  const Block block{.solver = "<CondensedStaticSolver/>", .loads = "<FixedLagrangianConstraint name=\"pin\" indices=\"66\"/>"};
  Simulation simulation = simulationFromText(block.text());
  const StepReport report = simulation.step();
  EXPECT_TRUE(report.diverged);
  for (const char* word : {"/body/pin", "node 66", "surfaceIndices"})
    EXPECT_NE(report.reason.find(word), std::string::npos) << word << " in: " << report.reason;
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
