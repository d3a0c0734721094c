// SPDX-License-Identifier: LGPL-2.1-or-later
// Friction turns spheres on frames: a ball that is thrown comes to roll, and two that meet obliquely spin.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "framework/simulation/simulation.h"
#include "tests/support/field_under_test.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// A solid ball of mass 2 on a frame.
std::string ball(const std::string& name, const std::string& place, const std::string& velocity, double radius) {
  return fmt::format(
      "<Node name='{0}'><EulerImplicitSolver/><SparseLDLSolver/><MechanicalObject template='Rigid3' position='{1} 0 0 0 1' "
      "velocity='{2} 0 0 0'/><UniformMass totalMass='2' inertia='{3} {3} {3}'/><SphereCollisionModel radius='{4}'/></Node>",
      name, place, velocity, 0.4 * 2 * radius * radius, radius);
}

std::string meeting(const std::string& method, const std::string& bodies, const std::string& gravity) {
  return fmt::format("<Node name='root' dt='0.01' gravity='{}'><CollisionPipeline/><CollisionResponse "
                     "response='FrictionContactConstraint' responseParams='mu=0.5'/><{} alarmDistance='0.1' "
                     "contactDistance='0.01'/>{}</Node>",
                     gravity, method, bodies);
}

/// Thrown with v without a turn it comes to roll at 5/7 v, which Euler's method knows without error.
TEST(RollingBalls, ABallThatIsThrownRolls) {
  for (const std::string method : {"MinProximityIntersection", "NewProximityIntersection", "LocalMinDistance"}) {
    Simulation simulation = simulationFromText(
        meeting(method,
                ball("a", "-3 0.21 2", "2 0 0", 0.2) +
                    "<Node name='floor'><MeshTopology position='-5 0 -5  5 0 -5  5 0 5  -5 0 5' triangles='0 2 1  0 3 2'/>"
                    "<MechanicalObject/><TriangleCollisionModel simulated='false' moving='false'/></Node>",
                "0 -9.81 0"));
    for (int i = 0; i < 60; ++i) ASSERT_FALSE(simulation.step().failed());
    const ConstRows v = simulation.states()[0]->v();
    EXPECT_LT((v[0] - Vec3(10.0 / 7, 0, 0)).norm(), 1e-6) << method;
    EXPECT_LT((v[1] - Vec3(0, 0, -10.0 / 7 / 0.2)).norm(), 1e-5) << method;
    EXPECT_NEAR(simulation.states()[0]->x()[0].y(), 0.21, 1e-9) << method;
  }
}

/// What one gains the other loses, and the torque of each is that of the force on its surface: I w = -r n x p, p on the second.
TEST(RollingBalls, TwoThatMeetObliquelySpin) {
  for (const std::string method : {"MinProximityIntersection", "NewProximityIntersection", "LocalMinDistance"}) {
    const double r[2] = {0.2, 0.3};
    Simulation simulation = simulationFromText(
        meeting(method, ball("a", "0 0 0", "0 0 0", r[0]) + ball("b", "1 0.3 0.1", "-2 0 0", r[1]), "0 0 0"));
    const State &a = *simulation.states()[0], &b = *simulation.states()[1];
    Vec3 push = Vec3::Zero(), n;
    for (int i = 0; i < 60 && push.isZero(0); ++i) {
      n = (b.x()[0] - a.x()[0]).normalized();
      const Vec3 before = 2 * Vec3(b.v()[0]);
      ASSERT_FALSE(simulation.step().failed());
      if (a.v()[0].norm() > 1e-6) push = 2 * Vec3(b.v()[0]) - before;
    }
    ASSERT_GT(push.norm(), 0.01) << method;
    EXPECT_LT((2 * Vec3(a.v()[0]) + push).norm(), 1e-8) << method;
    const Vec3 turning = n.cross(push);
    ASSERT_GT(turning.norm(), 0.001) << method;
    EXPECT_LT((0.4 * 2 * r[0] * Vec3(a.v()[1]) + turning).norm(), 1e-7) << method;
    EXPECT_LT((0.4 * 2 * r[1] * Vec3(b.v()[1]) + turning).norm(), 1e-7) << method;
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
