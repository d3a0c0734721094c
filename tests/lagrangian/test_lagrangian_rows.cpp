// SPDX-License-Identifier: LGPL-2.1-or-later
// Conditions that are hard to solve together: said twice, against each other, between frames, with an iterative solver, and
// what is said of those that do not hold.
#include <Eigen/Geometry>

#include "framework/mechanics/frames.h"
#include "tests/lagrangian/lagrangian_scenes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

using namespace lagrangian;

const std::string two_points = "<MechanicalObject name=\"dofs\" position=\"0 0 0  1 0 0\"/><UniformMass totalMass=\"2\"/>";

/// Rows that say the same share the force.
TEST(LagrangianRows, WhatIsSaidTwiceIsSolvedOnce) {
  const std::string link = "<DistanceLagrangianConstraint first_point=\"0\" second_point=\"1\"/>";
  std::vector<Vec3> ends;
  std::vector<double> forces;
  for (const int times : {1, 3}) {
    std::string links;
    for (int i = 0; i < times; ++i) links += link;
    Simulation simulation = simulationFromText(sceneOf(two_points + "<FixedProjectiveConstraint indices=\"0\"/>" + links));
    run(simulation, 30);
    ends.push_back(at(simulation, 1));
    double sum = 0;
    for (const double force : numbersOf(simulation, "DistanceLagrangianConstraint", "forces")) sum += force;
    forces.push_back(sum);
  }
  EXPECT_LT((ends[0] - ends[1]).norm(), 1e-10);
  EXPECT_NEAR(forces[0], forces[1], 1e-8);
  EXPECT_GT(std::abs(forces[0]), 1);
}

TEST(LagrangianRows, WhatIsAgainstEachOtherIsSaidByName) {
  Simulation simulation =
      simulationFromText(sceneOf(
          two_points + "<DistanceLagrangianConstraint name=\"short\" first_point=\"0\" second_point=\"1\" distances=\"1\"/>"
                       "<DistanceLagrangianConstraint name=\"long\" first_point=\"0\" second_point=\"1\" distances=\"1.5\"/>"));
  const StepReport report = simulation.step();
  EXPECT_FALSE(report.constraints_converged);
  EXPECT_FALSE(report.diverged);
  expectContains(report.constraint_reason, " does not hold: a condition is off by 0.25");
  EXPECT_TRUE(report.constraint_reason.find("/short") != std::string::npos ||
              report.constraint_reason.find("/long") != std::string::npos);
}

/// Conjugate gradients of a loose tolerance make W no symmetric matrix. The conditions hold all the same.
TEST(LagrangianRows, ConditionsHoldWithAnIterativeSolver) {
  Simulation simulation = simulationFromText(
      "<Node name=\"root\" dt=\"0.01\" gravity=\"0 -10 0\"><EulerImplicitSolver/><CGLinearSolver iterations=\"100\" "
      "tolerance=\"1e-4\"/>"
      "<RegularGridTopology n=\"6 3 3\" min=\"0 0 0\" max=\"5 2 2\"/><MechanicalObject/><UniformMass totalMass=\"1\"/>"
      "<HexahedronFEMForceField method=\"large\" youngModulus=\"500\" poissonRatio=\"0.3\"/>"
      "<FixedLagrangianConstraint indices=\"0 6 12\"/><DistanceLagrangianConstraint first_point=\"17 22\" second_point=\"53 "
      "40\"/></Node>");
  for (int i = 0; i < 10; ++i) {
    run(simulation, 1);
    if (HasFatalFailure()) return;
    ASSERT_LT(at(simulation, 0).norm(), 1e-9);
    ASSERT_NEAR((at(simulation, 17) - at(simulation, 53)).norm(), 2, 1e-9);
  }
}

/// Nothing acts from outside: two frames that are joined keep the momentum that they had, and turn as one.
TEST(LagrangianRows, FramesThatAreJoinedMoveAsOne) {
  const Vec3 apart(1, 0.5, 0);
  for (const char* keep : {"", "keepOrientationDifference=\"1\""}) {
    SCOPED_TRACE(keep);
    const Quaternion turned = keep[0] ? turnedBy(Vec3(0.3, -0.2, 0.5)) : Quaternion::Identity();
    Simulation simulation = simulationFromText(sceneOf(
        fmt::format(
            "<MechanicalObject template=\"Rigid3\" position=\"0 0 0  0 0 0 1   1 0.5 0  {:.17g} {:.17g} {:.17g} {:.17g}\" "
            "velocity=\"0 0 0  0 0 2   1 0 0  0 1 0\"/><UniformMass totalMass=\"2\" inertia=\"0.1 0.1 0.1\"/>"
            "<BilateralLagrangianConstraint first_point=\"0\" second_point=\"1\" rest_vector=\"1 0.5 0\" {}/>",
            turned.x(), turned.y(), turned.z(), turned.w(), keep),
        0.01, "0 0 0"));
    for (int i = 0; i < 30; ++i) {
      run(simulation, 1);
      if (HasFatalFailure()) return;
      const ConstRows x = simulation.states()[0]->x(), v = simulation.states()[0]->v();
      ASSERT_LT((Vec3(x[2]) - Vec3(x[0]) - apart).norm(), 1e-10);
      ASSERT_LT(rotationVector(orientationIn(x, 3) * (orientationIn(x, 1) * turned).conjugate()).norm(), 1e-10);
      ASSERT_LT((Vec3(v[0]) + Vec3(v[2]) - Vec3(1, 0, 0)).norm(), 1e-12) << "momentum";
      ASSERT_LT((Vec3(v[1]) + Vec3(v[3]) - Vec3(0, 1, 2)).norm(), 1e-10) << "equal and opposite torques";
    }
  }
}

/// A frame that is held bears its weight, and the torque that acts on it.
TEST(LagrangianRows, AFrameThatIsHeldStays) {
  Simulation simulation =
      simulationFromText(sceneOf("<MechanicalObject template=\"Rigid3\" position=\"1 2 3  0 0 0 1\" velocity=\"0 0 0  1 0 "
                                 "0\"/><UniformMass totalMass=\"2\" "
                                 "inertia=\"0.1 0.1 0.1\"/><ConstantForceField indices=\"0\" forces=\"0 0 0  0 0 "
                                 "4\"/><FixedLagrangianConstraint indices=\"0\"/>"));
  run(simulation, 3);
  EXPECT_LT((at(simulation, 0) - Vec3(1, 2, 3)).norm(), 1e-12);
  EXPECT_LT(rotationVector(orientationIn(simulation.states()[0]->x(), 1)).norm(), 1e-12);
  const std::vector<double> forces = numbersOf(simulation, "FixedLagrangianConstraint", "forces");
  ASSERT_EQ(forces.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(forces[i], i == 1 ? 20 : i == 5 ? -4 : 0, 1e-9) << i;
}

/// The distances of points that follow frames are known when the first step begins: their positions are written in the frames.
TEST(LagrangianRows, MappedPointsKeepTheDistanceThatTheyStartWith) {
  Simulation simulation = simulationFromText(sceneOf(
      "<MechanicalObject template=\"Rigid3\" position=\"0 0 0  0 0 0 1   3 0 0  0 0 1 0\" velocity=\"0 0 0  0 0 1   0 1 0  2 0 "
      "0\"/>"
      "<UniformMass totalMass=\"2\" inertia=\"0.1 0.1 0.1\"/><Node name=\"ends\"><MechanicalObject position=\"0.5 0 0  0.5 0.2 "
      "0\"/>"
      "<RigidMapping rigidIndexPerPoint=\"0 1\"/><DistanceLagrangianConstraint first_point=\"0\" second_point=\"1\"/></Node>",
      0.01, "0 0 0"));
  for (int i = 0; i < 20; ++i) {
    run(simulation, 1);
    if (HasFatalFailure()) return;
    ASSERT_NEAR((at(simulation, 1, 1) - at(simulation, 0, 1)).norm(), std::hypot(2, 0.2), 1e-10) << "step " << i;
  }
}

/// A pendulum beside points that are held: what answers to their rows is solved for once in a step, and what answers to the rod in each
/// round, so that it acts along the rod as it is at the end.
TEST(LagrangianRows, GradientsThatStayAreSolvedForOnce) {
  constexpr double dt = 0.1;
  constexpr int held = 9;
  Simulation simulation = simulationFromText(
      sceneOf("<MechanicalObject position=\"0 0 0  1 0 0  2 0 0  3 0 0  4 0 0  5 0 0  6 0 0  7 0 0  8 0 0  9 0 0\"/>"
              "<UniformMass vertexMass=\"1\"/><FixedLagrangianConstraint indices=\"0 1 2 3 4 5 6 7 8\"/>"
              "<DistanceLagrangianConstraint first_point=\"8\" second_point=\"9\"/>",
              dt));
  for (int i = 0; i < 5; ++i) {
    const Vec3 before = at(simulation, held), velocity = simulation.states()[0]->v()[held];
    const StepReport report = simulation.step();
    ASSERT_FALSE(report.failed()) << report.reason;
    const int of_rod = report.linear_iterations - 1 - 3 * held;  // besides the free motion and what holds points
    EXPECT_GE(of_rod, 2) << "rounds in which the rod turns";
    EXPECT_LT(of_rod, 3 * held);
    for (Index node = 0; node < held; ++node) EXPECT_LT((at(simulation, node) - Vec3(node, 0, 0)).norm(), 1e-12) << node;
    const Vec3 rod = at(simulation, held) - at(simulation, held - 1), impulse = (at(simulation, held) - before) / dt - velocity;
    EXPECT_NEAR(rod.norm(), 1, 1e-10);
    EXPECT_LT((impulse - dt * Vec3(0, -g, 0)).cross(rod).norm(), 1e-10) << i;
  }
}

/// Across a spring that is pressed to half its length the matrix is not positive: dt^2 k is far above m. The node stays all the same.
TEST(LagrangianRows, ANodeThatWouldBuckleIsHeld) {
  for (const char* solver : {"<SparseLUSolver/>", "<SVDLinearSolver/>", "<MinResLinearSolver iterations=\"50\" tolerance=\"1e-14\"/>"}) {
    SCOPED_TRACE(solver);
    Simulation simulation = simulationFromText(
        std::string("<Node name=\"root\" dt=\"0.1\" gravity=\"0 -10 0\"><EulerImplicitSolver/>") + solver +
        "<MechanicalObject position=\"0 0 0  0.5 0 0\"/><UniformMass totalMass=\"0.2\"/><FixedProjectiveConstraint indices=\"0\"/>"
        "<SpringForceField springsIndices1=\"0\" springsIndices2=\"1\" lengths=\"1\" stiffness=\"1000\"/>"
        "<FixedLagrangianConstraint indices=\"1\"/></Node>");
    run(simulation, 3);
    EXPECT_LT((at(simulation, 1) - Vec3(0.5, 0, 0)).norm(), 1e-10);
    const std::vector<double> forces = numbersOf(simulation, "FixedLagrangianConstraint", "forces");
    ASSERT_EQ(forces.size(), 3u);
    EXPECT_NEAR(forces[0], -500, 1e-6) << "what the spring pushes with";
    EXPECT_NEAR(forces[1], 1, 1e-7) << "the weight";
  }
}

/// A number that something pushes against its bound rests there, and bears the force.
TEST(LagrangianRows, AStopperRestsUnderAForce) {
  for (const char* integrator :
       {"<EulerImplicitSolver/>", "<BDFOdeSolver/>", "<EulerImplicitSolver newtonIterations=\"5\"/>"}) {
    SCOPED_TRACE(integrator);
    Simulation simulation = simulationFromText(sceneOf(
        "<MechanicalObject template=\"Vec1\" position=\"0\"/><UniformMass totalMass=\"3\"/><ConstantForceField indices=\"0\" "
        "forces=\"6\"/><StopperLagrangianConstraint index=\"0\" min=\"-0.5\" max=\"0.5\"/>",
        0.01, "0 0 0", integrator));
    run(simulation, 50);
    EXPECT_NEAR(at(simulation, 0).x(), 0.5 * 2 * 1e-4 * 50 * 51, 1e-10) << "free so far";
    run(simulation, 60);
    EXPECT_NEAR(at(simulation, 0).x(), 0.5, 1e-12);
    EXPECT_NEAR(simulation.states()[0]->v()[0].x(), 0, 1e-10);
    const std::vector<double> forces = numbersOf(simulation, "StopperLagrangianConstraint", "forces");
    ASSERT_EQ(forces.size(), 2u);
    EXPECT_NEAR(forces[0], 0, 1e-12);
    EXPECT_NEAR(forces[1], 6, 1e-9);
  }
}

/// A wire that is free is moved by the bead on it: momentum stays, and the bead stays on the wire.
TEST(LagrangianRows, AFreeWireFeelsItsBead) {
  Simulation simulation = simulationFromText(sceneOf(
      "<MechanicalObject position=\"0 0 0  2 0 0  0.7 0 0\" velocity=\"0 0 0  0 0 0  0.5 3 1\"/><UniformMass totalMass=\"3\"/>"
      "<DistanceLagrangianConstraint first_point=\"0\" second_point=\"1\"/>"
      "<SlidingLagrangianConstraint sliding_point=\"2\" axis_1=\"0\" axis_2=\"1\"/>",
      0.01, "0 0 0"));
  for (int i = 0; i < 100; ++i) {
    run(simulation, 1);
    if (HasFatalFailure()) return;
    const Vec3 u = (at(simulation, 1) - at(simulation, 0)).normalized(), from = at(simulation, 2) - at(simulation, 0);
    ASSERT_LT(u.cross(from).norm(), 1e-10) << "step " << i;
    Vec3 sum = Vec3::Zero();
    for (Index k = 0; k < 3; ++k) sum += simulation.states()[0]->v()[k];
    ASSERT_LT((sum - Vec3(0.5, 3, 1)).norm(), 1e-11) << "step " << i;
  }
}

TEST(LagrangianRows, WhatDoesNotFitIsRefused) {
  const std::string frame =
      "<MechanicalObject name=\"frames\" template=\"Rigid3\" position=\"0 0 0  0 0 0 1\"/><UniformMass totalMass=\"2\" "
      "inertia=\"1 1 1\"/>";
  expectContains(problemsOf(sceneOf(frame + "<DistanceLagrangianConstraint first_point=\"0\" second_point=\"0\"/>")),
                 "acts on points, and /frames has rigid frames");
  expectContains(problemsOf(sceneOf(two_points + "<Node name=\"b\">" + frame +
                                    "</Node><BilateralLagrangianConstraint object2=\"@b/frames\"/>")),
                 "one has rigid frames and the other points");
  expectContains(problemsOf(sceneOf(two_points + "<StopperLagrangianConstraint/>")), "acts on numbers, and /dofs has others");
  expectContains(
      problemsOf(sceneOf(two_points + "<SlidingLagrangianConstraint sliding_point=\"1\" axis_1=\"0\" axis_2=\"1\"/>")),
      "sliding_point 1 is a point of its own line");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
