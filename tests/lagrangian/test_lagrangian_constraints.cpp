// SPDX-License-Identifier: LGPL-2.1-or-later
// Constraints by forces against closed forms: chains, a bead on a wire, stops, contact with friction.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "tests/lagrangian/lagrangian_scenes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

using namespace lagrangian;

/// A pendulum of six links that falls from level keeps all its lengths.
TEST(LagrangianConstraints, AChainOfPendulumsKeepsItsLengths) {
  Simulation simulation = simulationFromText(sceneOf(chain(6, 6, 1) + "<FixedProjectiveConstraint indices=\"0\"/>"));
  for (int i = 0; i < 200; ++i) {
    run(simulation, 1);
    if (HasFatalFailure()) return;
    for (Index k = 0; k < 6; ++k)
      ASSERT_NEAR((at(simulation, k + 1) - at(simulation, k)).norm(), 1, 1e-10) << "step " << i << ", link " << k;
  }
  EXPECT_LT(at(simulation, 6).y(), -1) << "it swings";
}

/// Edges whose mapped change of length stays zero are rods, and the forces are the tensions of those that hang at rest.
TEST(LagrangianConstraints, MappedDistancesThatStayZeroAreRods) {
  const std::string rods = "<Node name='rods'><MeshTopology position='{0}' edges='{1}'/><MechanicalObject template='Vec1'/>"
                           "<DistanceMapping/><UniformLagrangianConstraint/></Node>";
  const std::string chain = "0 0 0  1 0 0  2 0 0  3 0 0", held = "<FixedProjectiveConstraint indices='0'/>";
  Simulation swinging =
      simulationFromText(sceneOf("<MechanicalObject position='" + chain + "'/><UniformMass totalMass='4'/>" + held +
                                 fmt::format(fmt::runtime(rods), chain, "0 1  1 2  2 3")));
  double lowest = 0;
  for (int i = 0; i < 200; ++i) {
    run(swinging, 1);
    if (HasFatalFailure()) return;
    for (Index k = 0; k < 3; ++k) ASSERT_NEAR((at(swinging, k + 1) - at(swinging, k)).norm(), 1, 1e-9) << "step " << i;
    lowest = std::min(lowest, at(swinging, 3).y());
  }
  EXPECT_LT(lowest, -2) << "it swings";
  const std::string plumb = "0 0 0  0 -1 0  0 -2 0";
  Simulation hanging =
      simulationFromText(sceneOf("<MechanicalObject position='" + plumb + "'/><UniformMass totalMass='6'/>" + held +
                                 fmt::format(fmt::runtime(rods), plumb, "0 1  1 2")));
  run(hanging, 3);
  const std::vector<double> tension = numbersOf(hanging, "UniformLagrangianConstraint", "forces");
  ASSERT_EQ(tension.size(), 2u);
  EXPECT_NEAR(std::abs(tension[0]), 2 * 2 * g, 1e-9);
  EXPECT_NEAR(std::abs(tension[1]), 2 * g, 1e-9);
}

TEST(LagrangianConstraints, APointThatStaysZeroStandsAtTheOrigin) {
  Simulation simulation = simulationFromText(
      sceneOf("<MechanicalObject position='0 0 0  3 0 0'/><UniformMass totalMass='4'/><Node name='held'><MechanicalObject "
              "position='0 0 0'/><SubsetMapping indices='0'/><UniformLagrangianConstraint/></Node>"));
  run(simulation, 10);
  EXPECT_LT(at(simulation, 0).norm(), 1e-14);
  EXPECT_NEAR(numbersOf(simulation, "UniformLagrangianConstraint", "forces").at(1), 2 * g, 1e-11);
  expectContains(problemsOf(sceneOf("<MechanicalObject template='Rigid3' position='0 0 0 0 0 0 1'/><UniformMass/>"
                                    "<UniformLagrangianConstraint/>")),
                 "acts on points or numbers");
}

/// Nothing but round-off of the free motion is there to measure conditions by.
TEST(LagrangianConstraints, APointIsHeldAtTheOrigin) {
  Simulation simulation = simulationFromText(
      sceneOf("<MechanicalObject position='0 0 0'/><UniformMass totalMass='2'/><FixedLagrangianConstraint indices='0'/>"));
  run(simulation, 10);
  EXPECT_LT(at(simulation, 0).norm(), 1e-17);
  EXPECT_NEAR(numbersOf(simulation, "FixedLagrangianConstraint", "forces").at(1), 2 * g, 1e-11);
}

/// Without gravity a chain that turns and flies keeps its momentum.
TEST(LagrangianConstraints, AFreeChainKeepsItsMomentum) {
  Simulation simulation =
      simulationFromText(sceneOf(chain(3, 3, 1, "velocity=\"1 2 0  0 -1 3  0 0 0  2 1 -1\""), 0.01, "0 0 0"));
  run(simulation, 200);
  Vec3 sum = Vec3::Zero();
  for (Index i = 0; i < 4; ++i) sum += simulation.states()[0]->v()[i];
  EXPECT_LT((sum - Vec3(3, 2, 2)).norm(), 1e-11);
}

/// The slopes of a chain that hangs at rest: tan = (V - i w) / H, the same H in all links. H by bisection of the span.
void expectCatenary(int n, double span, double link, double dt, int steps, const std::string& iterations = "") {
  const double w = 0.5 * g;
  Simulation simulation =
      simulationFromText(sceneOf(chain(n, span, link) + fmt::format("<FixedProjectiveConstraint indices=\"0 {}\"/>", n), dt,
                                 "0 -10 0", "<EulerImplicitSolver rayleighMass=\"4\" " + iterations + "/>"));
  run(simulation, steps);
  const auto width = [&](double h) {
    double sum = 0;
    for (int i = 0; i < n; ++i) sum += link / std::hypot(1, ((n - 1) / 2. - i) * w / h);
    return sum;
  };
  double low = 1e-3, high = 1e5;
  for (int i = 0; i < 200; ++i) (width(0.5 * (low + high)) < span ? low : high) = 0.5 * (low + high);
  Vec3 expected = Vec3::Zero();
  for (Index i = 0; i < n; ++i) {
    const double slope = -((n - 1) / 2. - i) * w / low, along = link / std::hypot(1, slope);
    expected += Vec3(along, along * slope, 0);
    EXPECT_LT((at(simulation, i + 1) - expected).norm(), 1e-6) << "node " << i + 1;
  }
}

TEST(LagrangianConstraints, AHangingChainIsACatenary) { expectCatenary(10, 6, 0.8, 0.05, 400); }

/// Tension holds its links across more than their inertia does: the first step turns some by their own length.
TEST(LagrangianConstraints, ALongChainIsACatenaryAfterLargeSteps) {
  expectCatenary(40, 40, 1.2, 0.06, 700);
  expectCatenary(40, 40, 1.2, 0.12, 350, "newtonIterations=\"50\"");
}

/// A bead slides down a wire of 45 degrees as a free fall of g sin 45, and stops at its end.
TEST(LagrangianConstraints, ABeadSlidesDownAWireAndStopsAtItsEnd) {
  Simulation simulation = simulationFromText(
      sceneOf("<MechanicalObject name=\"dofs\" position=\"0 0 0  3 -3 0  0.5 -0.5 0\"/><UniformMass totalMass=\"3\"/>"
              "<FixedProjectiveConstraint indices=\"0 1\"/>"
              "<SlidingLagrangianConstraint sliding_point=\"2\" axis_1=\"0\" axis_2=\"1\"/>"));
  constexpr int n = 60;
  run(simulation, n);
  const double way = 0.5 * g * 1e-4 * n * (n + 1) / 2;  // g sin^2 of 45 degrees, in both directions
  EXPECT_LT((at(simulation, 2) - Vec3(0.5 + way, -0.5 - way, 0)).norm(), 1e-10);
  run(simulation, 200);
  EXPECT_LT((at(simulation, 2) - Vec3(3, -3, 0)).norm(), 1e-10);
  const std::vector<double> forces = numbersOf(simulation, "SlidingLagrangianConstraint", "forces");
  ASSERT_EQ(forces.size(), 4u);
  EXPECT_NEAR(forces[3], g / std::sqrt(2), 1e-9) << "the end bears what pulls along the wire";
}

/// Along a curve: corner by corner, always on it.
TEST(LagrangianConstraints, ABeadFollowsACurve) {
  Simulation simulation = simulationFromText(
      sceneOf("<MechanicalObject name=\"dofs\" position=\"0 0 0  1 -1 0  2 -1.2 0  3 -1.2 0  0.2 -0.2 0\"/><UniformMass "
              "totalMass=\"5\"/><FixedProjectiveConstraint indices=\"0 1 2 3\"/>"
              "<SlidingLagrangianConstraint sliding_point=\"4\" curve=\"0 1 2 3\"/>"));
  run(simulation, 150);
  EXPECT_LT((at(simulation, 4) - Vec3(3, -1.2, 0)).norm(), 1e-9);
}

TEST(LagrangianConstraints, AStopperStops) {
  Simulation simulation = simulationFromText(
      sceneOf("<MechanicalObject template=\"Vec1\" position=\"0\" velocity=\"2\"/><UniformMass totalMass=\"3\"/>"
              "<StopperLagrangianConstraint index=\"0\" min=\"-0.5\" max=\"0.5\"/>",
              0.01, "0 0 0"));
  run(simulation, 24);
  EXPECT_NEAR(at(simulation, 0).x(), 0.48, 1e-12);
  run(simulation, 3);
  EXPECT_NEAR(at(simulation, 0).x(), 0.5, 1e-12);
  EXPECT_NEAR(simulation.states()[0]->v()[0].x(), 0, 1e-10);
}

/// Two bodies, an integrator each: joined, they go on with their common velocity.
TEST(LagrangianConstraints, JoinedBodiesShareTheirMomentum) {
  const auto body = [](const char* name, const char* more) {
    return fmt::format(
        "<Node name=\"{}\"><EulerImplicitSolver/><SparseLDLSolver/><MechanicalObject name=\"dofs\" {}/>"
        "<UniformMass vertexMass=\"{}\"/></Node>",
        name, more, name[0] == 'a' ? 1 : 3);
  };
  Simulation simulation = simulationFromText(
      "<Node name=\"root\" dt=\"0.01\" gravity=\"0 0 0\">" + body("a", "position=\"0 0 0\" velocity=\"4 0 0\"") +
      body("b", "position=\"0 1 0\"") +
      "<BilateralLagrangianConstraint object1=\"@a/dofs\" object2=\"@b/dofs\" first_point=\"0\" second_point=\"0\" "
      "rest_vector=\"0 1 0\"/></Node>");
  run(simulation, 5);
  EXPECT_LT((simulation.states()[0]->v()[0] - Vec3(1, 0, 0)).norm(), 1e-12);
  EXPECT_LT((at(simulation, 0, 1) - at(simulation, 0) - Vec3(0, 1, 0)).norm(), 1e-12);
}

/// A point of a rigid frame that is held: the frame swings about it.
TEST(LagrangianConstraints, AFrameSwingsAboutAPointThatIsHeld) {
  Simulation simulation = simulationFromText(sceneOf(
      "<Node name=\"body\"><MechanicalObject name=\"frame\" template=\"Rigid3\" position=\"0 0 0  0 0 0 1\"/><UniformMass "
      "totalMass=\"2\" inertia=\"0.1 0.1 0.1\"/><Node name=\"tip\"><MechanicalObject name=\"dofs\" position=\"-0.5 0 0\"/>"
      "<RigidMapping/><FixedLagrangianConstraint indices=\"0\"/></Node></Node>"));
  for (int i = 0; i < 100; ++i) {
    run(simulation, 1);
    if (HasFatalFailure()) return;
    ASSERT_LT((at(simulation, 0, 1) - Vec3(-0.5, 0, 0)).norm(), 1e-10) << "step " << i;
  }
  EXPECT_NEAR((at(simulation, 0) - Vec3(-0.5, 0, 0)).norm(), 0.5, 1e-10);
  EXPECT_LT(at(simulation, 0).y(), -0.1);
}

/// tan 0.5: what lies on a slope sticks for certain with mu 0.5, to round-off, and slides with 0.49 as Coulomb says.
TEST(LagrangianConstraints, FrictionSticksAndSlidesExactly) {
  const double c = 1 / std::sqrt(1.25), s = 0.5 * c;
  for (const double mu : {0.6, 0.5, 0.49, 0.2}) {
    Simulation simulation = simulationFromText(fmt::format(
        "<Node name=\"root\" dt=\"0.01\" gravity=\"{} {} 0\"><CollisionPipeline/><CollisionResponse "
        "response=\"FrictionContactConstraint\" responseParams=\"mu={}\"/><MinProximityIntersection alarmDistance=\"0.2\" "
        "contactDistance=\"0.1\"/><Node name=\"a\"><EulerImplicitSolver/><SparseLDLSolver/><MechanicalObject "
        "position=\"0.1 0.3 0.2\"/><UniformMass totalMass=\"2\"/><SphereCollisionModel radius=\"0.2\"/></Node><Node "
        "name=\"floor\"><MeshTopology position=\"-9 0 -7  9 0 -9  9 0 9  -9 0 9\" triangles=\"0 1 2  0 2 3\"/>"
        "<MechanicalObject/><TriangleCollisionModel simulated=\"0\"/></Node></Node>",
        g * s, -g * c, mu));
    constexpr int n = 100;
    run(simulation, n);
    const double acceleration = std::max(0.0, g * (s - mu * c));
    EXPECT_NEAR(at(simulation, 0).x() - 0.1, acceleration * 1e-4 * n * (n + 1) / 2, 1e-9) << "mu " << mu;
    EXPECT_NEAR(at(simulation, 0).y(), 0.3, 1e-12);
    EXPECT_NEAR(at(simulation, 0).z(), 0.2, 1e-12);
  }
}

/// A ball on a ball on the floor: each comes down to its contact and stays, and a soft body under them is pressed.
TEST(LagrangianConstraints, BallsAreStacked) {
  const auto ball = [](const char* name, double height) {
    return fmt::format(
        "<Node name=\"{}\"><EulerImplicitSolver/><SparseLDLSolver/><MechanicalObject position=\"0.1 {} 0.2\"/>"
        "<UniformMass totalMass=\"2\"/><SphereCollisionModel radius=\"0.2\"/></Node>",
        name, height);
  };
  Simulation simulation = simulationFromText(
      "<Node name=\"root\" dt=\"0.01\" gravity=\"0 -10 0\"><CollisionPipeline/><CollisionResponse "
      "response=\"FrictionContactConstraint\"/><MinProximityIntersection alarmDistance=\"0.3\" contactDistance=\"0.1\"/>" +
      ball("a", 0.4) + ball("b", 0.95) + ball("c", 1.6) +
      "<Node name=\"floor\"><MeshTopology position=\"-9 0 -7  9 0 -9  9 0 9  -9 0 9\" triangles=\"0 1 2  0 2 3\"/>"
      "<MechanicalObject/><TriangleCollisionModel simulated=\"0\"/></Node></Node>");
  run(simulation, 100);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(at(simulation, 0, i).y(), 0.3 + 0.5 * double(i), 1e-9) << i;
}

/// Without inertia M v = f + J^T l. A node on a rod of length 1 about a fixed point, pulled along y: the step without the rod
/// comes back to the circle along the rod at its end, and the angle follows sin a = tanh(F t / m).
TEST(LagrangianConstraints, AnOverdampedNodeStaysOnItsRod) {
  constexpr double mass = 2, force = 3;
  double errors[2];
  for (const int fine : {0, 1}) {
    const double dt = fine ? 0.005 : 0.01;
    Simulation simulation = simulationFromText(
        sceneOf(fmt::format("<MechanicalObject name=\"dofs\" position=\"0 0 0  1 0 0\"/><UniformMass totalMass=\"{}\"/>"
                            "<FixedProjectiveConstraint indices=\"0\"/><ConstantForceField indices=\"1\" forces=\"0 {} 0\"/>"
                            "<DistanceLagrangianConstraint first_point=\"0\" second_point=\"1\" distances=\"1\"/>",
                            2 * mass, force),
                dt, "0 0 0", "<EulerImplicitSolver firstOrder=\"1\"/>"));
    Vec3 expected(1, 0, 0);
    for (int step = 0; step < (fine ? 100 : 50); ++step) {
      const Vec3 before = expected;
      expected = (expected + Vec3(0, dt * force / mass, 0)).normalized();
      run(simulation, 1);
      ASSERT_LT((at(simulation, 1) - expected).norm(), 1e-9) << step;
      const Vec3 velocity = simulation.systems()[0]->v[1];
      ASSERT_LT((velocity - (expected - before) / dt).norm(), 1e-7) << step;
    }
    errors[fine] = std::abs(at(simulation, 1).y() - std::tanh(force * 0.5 / mass));
  }
  EXPECT_LT(errors[0], 5e-3);
  EXPECT_NEAR(errors[0] / errors[1], 2, 0.05) << "of first order";
}

/// A cable that pulls an overdamped bar has the force and the shortening of one at rest, whatever the step.
TEST(LagrangianConstraints, AnOverdampedBodyUnderACableComesToRest) {
  for (const double dt : {1e-2, 1.0}) {
    Simulation simulation = simulationFromText(
        sceneOf("<MechanicalObject position=\"0 0 0  1 0 0  2 0 0\"/><UniformMass totalMass=\"3\"/>"
                "<RestShapeSpringsForceField stiffness=\"100\"/><CableConstraint indices=\"1 2\" pullPoint=\"-1 0 0\" "
                "valueType=\"displacement\" value=\"0.1\"/>",
                dt, "0 0 0", "<EulerImplicitSolver firstOrder=\"1\"/>"));
    run(simulation, 100);
    EXPECT_NEAR(numbersOf(simulation, "CableConstraint", "force").at(0), 10, 1e-6);
    EXPECT_NEAR(at(simulation, 2).x(), 1.9, 1e-8);
  }
}

TEST(LagrangianConstraints, WhatCannotHoldIsSaid) {
  const std::string content =
      "<MechanicalObject name=\"dofs\" position=\"0 0 0  1 0 0\"/><UniformMass totalMass=\"2\"/>"
      "<DistanceLagrangianConstraint name=\"chain\" first_point=\"0\" second_point=\"1\" distances=\"2\"/>";
  expectContains(problemsOf(sceneOf(content, 0.01, "0 0 0", "<EulerExplicitSolver/>")),
                 "does not support the constraint");
  Simulation held = simulationFromText(sceneOf(content + "<FixedProjectiveConstraint indices=\"0 1\"/>"));
  const StepReport report = held.step();
  EXPECT_FALSE(report.constraints_converged);
  expectContains(report.constraint_reason, "the Lagrangian constraint /chain does not hold: a condition is off by 1");
  expectContains(problemsOf(sceneOf("<MechanicalObject position=\"0 0 0\"/><UniformMass totalMass=\"2\"/>"
                                    "<BilateralLagrangianConstraint first_point=\"0\" second_point=\"7\"/>")),
                 "second_point names node 7");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
