// SPDX-License-Identifier: LGPL-2.1-or-later
// Constraints by forces against closed forms: chains, a bead on a wire, stops, cables, cavities, contact with friction.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <sstream>

#include "framework/simulation/simulation.h"
#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

constexpr double g = 10;

std::string sceneOf(const std::string& content, double dt = 0.01, const std::string& gravity = "0 -10 0",
                    const std::string& integrator = "<EulerImplicitSolver/>") {
  return fmt::format("<Node name=\"root\" dt=\"{}\" gravity=\"{}\">{}<SparseLDLSolver/>{}</Node>", dt, gravity, integrator,
                     content);
}

void run(Simulation& simulation, int steps) {
  for (int i = 0; i < steps; ++i) {
    const StepReport report = simulation.step();
    ASSERT_FALSE(report.failed()) << "step " << i << ": " << report.reason;
    ASSERT_TRUE(report.constraints_converged) << "step " << i << ": " << report.constraint_reason;
  }
}

std::vector<double> numbersOf(const Simulation& simulation, const std::string& type, const char* name) {
  std::vector<Component*> all;
  simulation.root().collect(all);
  std::vector<double> values;
  for (Component* component : all)
    if (component->type() == type) {
      std::istringstream text(component->data().find(name)->print());
      for (double value = 0; text >> value;) values.push_back(value);
    }
  return values;
}

Vec3 at(const Simulation& simulation, Index node, std::size_t state = 0) { return simulation.states()[state]->x()[node]; }

/// A chain of links of one length: nodes 0 to n, the middle as deep as they reach.
std::string chain(int n, double span, double length, const std::string& velocity = "") {
  std::string positions, first, second, distances;
  const double dip = std::sqrt(std::max(0.0, length * length - span * span / n / n));
  for (int i = 0; i <= n; ++i) positions += fmt::format("{} {} 0  ", span * i / n, -dip * std::min(i, n - i));
  for (int i = 0; i < n; ++i)
    first += fmt::format("{} ", i), second += fmt::format("{} ", i + 1), distances += fmt::format("{} ", length);
  return fmt::format("<MechanicalObject name=\"dofs\" position=\"{}\" {}/><UniformMass vertexMass=\"0.5\"/>"
                     "<DistanceLagrangianConstraint first_point=\"{}\" second_point=\"{}\" distances=\"{}\"/>",
                     positions, velocity, first, second, distances);
}

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
TEST(LagrangianConstraints, AHangingChainIsACatenary) {
  constexpr int n = 10;
  constexpr double span = 6, link = 0.8, w = 0.5 * g;
  Simulation simulation =
      simulationFromText(sceneOf(chain(n, span, link) + fmt::format("<FixedProjectiveConstraint indices=\"0 {}\"/>", n), 0.05,
                                 "0 -10 0", "<EulerImplicitSolver rayleighMass=\"4\"/>"));
  run(simulation, 400);
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
    return fmt::format("<Node name=\"{}\"><EulerImplicitSolver/><SparseLDLSolver/><MechanicalObject name=\"dofs\" {}/>"
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
  Simulation simulation = simulationFromText(
      sceneOf("<Node name=\"body\"><MechanicalObject name=\"frame\" template=\"Rigid3\" position=\"0 0 0  0 0 0 1\"/><UniformMass "
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

/// Springs of 100 N/m against a cable that is pulled by 0.1 m: 10 N, and the other way round, with any step.
TEST(LagrangianConstraints, ACableHasOneTensionWithAnyStep) {
  for (const double dt : {0.002, 0.02, 0.1})
    for (const char* type : {"displacement", "force"}) {
      SCOPED_TRACE(fmt::format("{}, dt {}", type, dt));
      Simulation simulation = simulationFromText(sceneOf(
          fmt::format("<MechanicalObject position=\"0 0 0  1 0 0  2 0 0\"/><UniformMass totalMass=\"3\"/>"
                      "<RestShapeSpringsForceField stiffness=\"100\"/><CableConstraint indices=\"1 2\" pullPoint=\"-1 0 0\" "
                      "valueType=\"{}\" value=\"{}\"/>",
                      type, type[0] == 'd' ? 0.1 : 10),
          dt, "0 0 0", "<EulerImplicitSolver rayleighMass=\"10\"/>"));
      run(simulation, int(std::lround(4 / dt)));
      EXPECT_NEAR(numbersOf(simulation, "CableConstraint", "force").at(0), 10, 1e-6);
      EXPECT_NEAR(numbersOf(simulation, "CableConstraint", "displacement").at(0), 0.1, 1e-8);
      EXPECT_NEAR(at(simulation, 2).x(), 1.9, 1e-8);
      EXPECT_NEAR(at(simulation, 1).x(), 1, 1e-8) << "the cable slides through it";
    }
}

/// A cable that cannot push hangs loose where its body comes nearer by itself.
TEST(LagrangianConstraints, ACableDoesNotPushWhereItMayNot) {
  Simulation simulation = simulationFromText(sceneOf(
      "<MechanicalObject position=\"1 0 0\" velocity=\"-1 0 0\"/><UniformMass totalMass=\"1\"/>"
      "<CableConstraint indices=\"0\" pullPoint=\"0 0 0\" value=\"0\" minForce=\"0\"/>",
      0.01, "0 0 0"));
  run(simulation, 10);
  EXPECT_NEAR(at(simulation, 0).x(), 0.9, 1e-12);
  EXPECT_EQ(numbersOf(simulation, "CableConstraint", "force").at(0), 0);
}

/// A box on springs: the pressure that a growth takes gives that growth; it bears on the area of each side.
TEST(LagrangianConstraints, ACavityUnderPressure) {
  const std::string cube = "0 0 0  1 0 0  1 1 0  0 1 0  0 0 1  1 0 1  1 1 1  0 1 1";
  const std::string faces = "0 2 1  0 3 2  4 5 6  4 6 7  0 1 5  0 5 4  3 7 6  3 6 2  0 4 7  0 7 3  1 2 6  1 6 5";
  const auto cavity = [&](const char* type, double value, double dt) {
    return sceneOf(fmt::format("<MechanicalObject position=\"{}\"/><UniformMass totalMass=\"1\"/><RestShapeSpringsForceField "
                               "stiffness=\"100\"/><SurfacePressureConstraint triangles=\"{}\" valueType=\"{}\" value=\"{}\"/>",
                               cube, faces, type, value),
                   dt, "0 0 0", "<EulerImplicitSolver rayleighMass=\"20\"/>");
  };
  double growth = 0;
  for (const double dt : {0.002, 0.02}) {
    Simulation simulation = simulationFromText(cavity("pressure", 40, dt));
    run(simulation, int(std::lround(3 / dt)));
    growth = numbersOf(simulation, "SurfacePressureConstraint", "volumeGrowth").at(0);
    // each node bears a third of what acts on its triangles
    std::istringstream list(faces);
    std::vector<Vec3> forces(8, Vec3::Zero());
    for (Index a, b, c; list >> a >> b >> c;) {
      const Vec3 p = at(simulation, a), area = 0.5 * (at(simulation, b) - p).cross(at(simulation, c) - p);
      for (const Index node : {a, b, c}) forces[std::size_t(node)] += 40 * area / 3;
    }
    for (Index node = 0; node < 8; ++node)
      EXPECT_LT((100 * (at(simulation, node) - simulation.states()[0]->rest_position[std::size_t(node)]) -
                 forces[std::size_t(node)]).norm(), 1e-6) << node;
    EXPECT_GT(growth, 0.5);
  }
  Simulation simulation = simulationFromText(cavity("volumeGrowth", growth, 0.01));
  run(simulation, 300);
  EXPECT_NEAR(numbersOf(simulation, "SurfacePressureConstraint", "cavityVolume").at(0), 1 + growth, 1e-10);
  EXPECT_NEAR(numbersOf(simulation, "SurfacePressureConstraint", "pressure").at(0), 40, 1e-5);
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
    return fmt::format("<Node name=\"{}\"><EulerImplicitSolver/><SparseLDLSolver/><MechanicalObject position=\"0.1 {} 0.2\"/>"
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

TEST(LagrangianConstraints, WhatCannotHoldIsSaid) {
  const std::string content = "<MechanicalObject name=\"dofs\" position=\"0 0 0  1 0 0\"/><UniformMass totalMass=\"2\"/>"
                              "<DistanceLagrangianConstraint first_point=\"0\" second_point=\"1\" distances=\"2\"/>";
  expectContains(problemsOf(sceneOf(content, 0.01, "0 0 0", "<EulerExplicitSolver/>")), "does not find the forces of the constraint");
  expectContains(problemsOf(sceneOf(content, 0.01, "0 0 0", "<EulerImplicitSolver firstOrder=\"1\"/>")), "firstOrder");
  Simulation held = simulationFromText(sceneOf(content + "<FixedProjectiveConstraint indices=\"0 1\"/>"));
  const StepReport report = held.step();
  EXPECT_FALSE(report.constraints_converged);
  expectContains(report.constraint_reason, "off by 1");
  expectContains(problemsOf(sceneOf("<MechanicalObject position=\"0 0 0\"/><UniformMass totalMass=\"2\"/>"
                                    "<BilateralLagrangianConstraint first_point=\"0\" second_point=\"7\"/>")),
                 "second_point names node 7");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
