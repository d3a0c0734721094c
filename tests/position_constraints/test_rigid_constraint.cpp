// SPDX-License-Identifier: LGPL-2.1-or-later
// Rigid sets against the motions of rigid bodies: tumbling, precession, pendulum, hinge.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <limits>
#include <numbers>

#include "tests/position_constraints/position_scenes.h"

namespace stroma::test {
namespace {

using std::numbers::pi;

TEST(RigidConstraint, AFreeBodyTumblesWithItsMomenta) {
  Simulation simulation = simulationFromText(rigid(brick, "", "0.01"));
  System& system = *simulation.systems()[0];
  // about the middle axis, where free rotation is unstable; and velocities that no rigid body has
  for (Index i = 0; i < system.x.count(); ++i)
    system.v[i] =
        Vec3(0.01, 3, 0.02).cross(Vec3(system.x[i])) + Vec3(0.1 * std::sin(double(i)), 0.2 * std::cos(double(i)), 0);
  // it stays where it is, because round-off of positions far away enters velocities over dt
  const Motion given = motionOf(system);
  for (Index i = 0; i < system.x.count(); ++i) system.v[i] -= given.linear / given.mass;
  const Motion start = motionOf(system);
  run(simulation, 1);
  const double energy = system.kineticEnergy();
  Vec3 first = system.x[1] - system.x[0];
  double most_turned = 0;
  for (int i = 0; i < 10000; ++i) {
    run(simulation, 1);
    ASSERT_LT(distortion(system), 1e-12) << i;
    ASSERT_NEAR(system.kineticEnergy(), energy, 0.02 * energy) << i;
    most_turned = std::max(most_turned, 1 - first.normalized().dot((system.x[1] - system.x[0]).normalized()));
  }
  EXPECT_GT(most_turned, 1) << "it tumbles";
  const Motion end = motionOf(system);
  EXPECT_LT(end.linear.norm(), 1e-11 * given.linear.norm());
  EXPECT_LT((end.angular - start.angular).norm(), 1e-11 * start.angular.norm());
  // The centre of rounded positions errs by up to eps |x| a step, |x| <= 2 m; over dt that enters the velocity, which
  // carries it through all steps that are left. Errors of N steps, each on its own, make
  // eps |x| sqrt(sum (N - k)^2) = eps |x| N^(3/2) / sqrt(3) = 2.6e-10 m.
  const double steps = 10000, round_off = 2 * std::numeric_limits<double>::epsilon();
  EXPECT_LT((end.centre - start.centre).norm(), round_off * steps * std::sqrt(steps / 3));
}

/// Ten thousand steps of free fall, 49 km: round-off of positions is then 7e-12 m, more than 1e-12 of these bodies.
TEST(PositionConstraints, FarFromTheOriginTheyHoldToRoundOff) {
  const std::string corners = "0 0 0  0.01 0 0  0 0.01 0  0 0 0.01";
  for (const char* constraint : {"<RigidConstraint/>", "<VolumeConstraint/>"}) {
    SCOPED_TRACE(constraint);
    Simulation simulation = simulationFromText(
        root("<EulerExplicitSolver/><MeshTopology position=\"" + corners +
                 "\" tetrahedra=\"0 1 2 3\"/><MechanicalObject/><UniformMass totalMass=\"1\"/>" + constraint,
             "0.01", "0 0 -9.81"));
    System& system = *simulation.systems()[0];
    for (Index i = 0; i < 4; ++i) system.v[i] = 0.3 * Vec3(1, 2, 3).cross(Vec3(system.x[i]));
    for (int i = 0; i < 10000; ++i) {
      const StepReport report = simulation.step();
      ASSERT_FALSE(report.diverged) << report.reason;
      ASSERT_TRUE(report.constraints_converged) << i << ": " << report.constraint_reason;
      ASSERT_LT(report.constraint_sweeps, 10) << i;
    }
    EXPECT_LT(system.x[0].z(), -4.9e4);
    if (constraint == std::string("<RigidConstraint/>")) {
      EXPECT_LT(distortion(system), 4 * 8 * 2.3e-16 * 4.91e4 / 0.01);
    }
  }
}

/// A free symmetric top: its axis turns about the angular momentum L at |L| / I_across. Second order in dt.
TEST(RigidConstraint, ASymmetricTopPrecesses) {
  const auto error = [](double dt) {
    Simulation simulation =
        simulationFromText(rigid("0.1 0 0  -0.1 0 0  0 0.1 0  0 -0.1 0  0 0 0.3  0 0 -0.3", "", std::to_string(dt)));
    System& system = *simulation.systems()[0];
    const Vec3 spin(1, 0, 8);
    for (Index i = 0; i < 6; ++i) system.v[i] = spin.cross(Vec3(system.x[i]));
    const double m = 0.5, across = 2 * m * (0.01 + 0.09), along = 4 * m * 0.01;
    const Vec3 momentum(across * spin.x(), 0, along * spin.z());
    for (int i = 0; i < std::lround(2 / dt); ++i) simulation.step();
    const Vec3 axis = (system.x[4] - system.x[5]).normalized();
    const Vec3 expected = Eigen::AngleAxisd(2 * momentum.norm() / across, momentum.normalized()) * Vec3(0, 0, 1);
    return (axis - expected).norm();
  };
  const double coarse = error(0.01), fine = error(0.005);
  EXPECT_LT(fine, 0.02);
  EXPECT_NEAR(coarse / fine, 4, 0.3);
}

/// About a principal axis sin(angle) = w dt, which no angle satisfies from w dt = 1 on: the angular momentum is kept,
/// or its loss is said. A bar has no inertia about its length.
TEST(RigidConstraint, AngularMomentumIsKeptOrItsLossIsSaid) {
  for (const char* positions : {"0.1 0 0  -0.1 0 0  0 0.2 0  0 -0.2 0  0 0 0.3  0 0 -0.3", "0 0.2 0  0 -0.2 0"})
    for (const double turn : {0.1, 0.7, 0.99, 1., 1.5, 2., 10.}) {
      SCOPED_TRACE(turn);
      Simulation simulation = simulationFromText(rigid(positions, "", "0.01"));
      System& system = *simulation.systems()[0];
      for (Index i = 0; i < system.x.count(); ++i) system.v[i] = Vec3(0, 0, turn / 0.01).cross(Vec3(system.x[i]));
      for (int i = 0; i < 20; ++i) {
        const Vec3 momentum = motionOf(system).angular, before = system.x[0];
        const StepReport report = simulation.step();
        ASSERT_FALSE(report.diverged) << report.reason;
        ASSERT_LT(distortion(system), 1e-12);
        const double loss = (motionOf(system).angular - momentum).norm() / momentum.norm();
        if (turn < 1) {
          ASSERT_TRUE(report.constraints_converged) << report.constraint_reason;
          const double angle = std::atan2(before.cross(Vec3(system.x[0])).z(), before.dot(system.x[0]));
          ASSERT_NEAR(std::sin(angle), turn, 1e-11);
        }
        if (turn > 1 && i == 0) {
          ASSERT_FALSE(report.constraints_converged);
          EXPECT_NE(report.constraint_reason.find("more than a quarter"), std::string::npos)
              << report.constraint_reason;
        }
        if (report.constraints_converged) {
          ASSERT_LT(loss, 1e-10);
        } else {
          ASSERT_NEAR(loss, 1 - 1 / turn, 1e-3);
          break;  // the next one starts from what is left
        }
      }
    }
}

/// A compound pendulum on one held node: small swings of period 2 pi sqrt(I / (m g d)).
TEST(RigidConstraint, OneHeldNodeIsAPivot) {
  Simulation simulation = simulationFromText(rigid("0 0 0  0 0 -0.4  0 0.1 -0.5  0 -0.1 -0.5",
                                                   "<FixedProjectiveConstraint indices=\"0\"/>", "0.001", "0 0 -9.81"));
  System& system = *simulation.systems()[0];
  for (Index i = 0; i < 4; ++i) system.v[i] = Vec3(0.01, 0, 0).cross(Vec3(system.x[i]));
  const double m = 0.5, inertia = m * (0.16 + 2 * 0.26), lever = m * (0.4 + 1.0);
  const double period = 2 * pi * std::sqrt(inertia / (lever * 9.81));
  int zeros = 0;
  double last = 0, first_zero = 0, last_zero = 0;
  for (int i = 0; i < 10000; ++i) {
    run(simulation, 1);
    ASSERT_EQ(system.x[0], Vec3(0, 0, 0));
    ASSERT_LT(distortion(system), 1e-12);
    const double swing = system.x[1].y();
    if (last < 0 && swing >= 0) {
      last_zero = simulation.time() - 0.001 * swing / (swing - last);
      if (zeros++ == 0) first_zero = last_zero;
    }
    last = swing;
  }
  ASSERT_GT(zeros, 3);
  EXPECT_NEAR((last_zero - first_zero) / (zeros - 1), period, 1e-4 * period);
}

TEST(RigidConstraint, TwoHeldNodesAreAHinge) {
  Simulation simulation =
      simulationFromText(rigid(brick, "<FixedProjectiveConstraint indices=\"0 1\"/>", "0.001", "0 0 -9.81"));
  System& system = *simulation.systems()[0];
  const double start = system.kineticEnergy() + system.gravityEnergy(system.x);
  double lowest_point = 1;
  for (int i = 0; i < 3000; ++i) {
    run(simulation, 1);
    ASSERT_LT(distortion(system), 1e-12);
    for (Index node = 0; node < system.x.count(); ++node)
      ASSERT_NEAR(system.x[node].x(), system.states()[0]->rest_position[node].x(), 1e-12);
    ASSERT_NEAR(system.kineticEnergy() + system.gravityEnergy(system.x), start, 0.5);
    lowest_point = std::min(lowest_point, system.x[2].z());
  }
  EXPECT_LT(lowest_point, -0.9) << "it swings through";
}

TEST(RigidConstraint, PrescribedNodesLeadIt) {
  Simulation simulation = simulationFromText(
      rigid(brick,
            "<LinearMovementProjectiveConstraint indices=\"0 1 2\" keyTimes=\"0 1\" movements=\"0 0 0  0.5 0.2 -0.3\" "
            "outside=\"hold\"/>",
            "0.01", "0 0 -9.81", implicit_euler));
  System& system = *simulation.systems()[0];
  for (int i = 0; i < 150; ++i) {
    run(simulation, 1);
    const double s = std::min(simulation.time(), 1.);
    const auto& rest = system.states()[0]->rest_position;
    for (Index node = 0; node < system.x.count(); ++node) {
      ASSERT_LT((system.x[node] - rest[node] - s * Vec3(0.5, 0.2, -0.3)).norm(), 1e-11) << node;
      if (i < 99) {
        ASSERT_LT((system.v[node] - Vec3(0.5, 0.2, -0.3)).norm(), 1e-10) << node;
      }
    }
  }
}

TEST(RigidConstraint, HeldNodesThatDoNotFitAreSaid) {
  expectConflict(simulationFromText(rigid(
                     brick,
                     "<FixedProjectiveConstraint indices=\"0\"/><LinearMovementProjectiveConstraint indices=\"1\" "
                     "keyTimes=\"0 1\" movements=\"0 0 0  0.5 0 0\"/>")),
                 "do not keep their distances");
  expectContains(
      problemsOf(root("<EulerExplicitSolver/><MechanicalObject position=\"0 0 0\"/><UniformMass totalMass=\"1\"/>"
                      "<RigidConstraint/>")),
      "two nodes or more");
}

}  // namespace
}  // namespace stroma::test
