// SPDX-License-Identifier: LGPL-2.1-or-later
// Frames that keep their twist about an axis, against turns in closed form.
#include <gtest/gtest.h>

#include <cmath>

#include "framework/mechanics/frames.h"
#include "tests/position_constraints/position_scenes.h"

namespace stroma::test {
namespace {

constexpr int steps = 50;

struct Turn {
  Quaternion orientation;
  Vec3 spin;
};

/// A frame without forces that starts turned by 2 atan2(0.3, 0.9) about x, after 0.5 s.
Turn turned(const std::string& velocity, const std::string& held) {
  Simulation simulation = simulationFromText(
      root("<EulerImplicitSolver/><CGLinearSolver iterations=\"50\" tolerance=\"1e-12\"/><MechanicalObject template=\"Rigid3\" "
           "position=\"0 0 0  0.3 0 0 0.9\" velocity=\"0 0 0  " + velocity + "\"/><UniformMass totalMass=\"1\" "
           "inertia=\"1 1 1\"/><TwistConstraint " + held + "/>"));
  for (int i = 0; i < steps; ++i) EXPECT_FALSE(simulation.step().failed());
  const System& system = *simulation.systems()[0];
  return {orientationIn(system.x, 1), Vec3(system.v[1])};
}
const Quaternion start = Quaternion(0.9, 0.3, 0, 0).normalized();

TEST(TwistConstraint, AFrameStaysAsItIsAboutTheHeldAxisAndKeepsItsVelocity) {
  const Turn end = turned("2 0 0", "FixedXRotation=\"true\"");
  EXPECT_LT(end.orientation.angularDistance(start), 1e-12);
  EXPECT_NEAR(end.spin[0], 2, 1e-12);
}

TEST(TwistConstraint, AFrameTurnsAboutTheAxesThatAreFree) {
  const Turn end = turned("2 0 0", "FixedYRotation=\"true\" FixedZRotation=\"true\"");
  EXPECT_LT(end.orientation.angularDistance(turnedBy(Vec3(2 * 0.01 * steps, 0, 0)) * start), 1e-12);
}

/// q = s t: the part of q along w and x is that of t, in whatever direction it is turned.
TEST(TwistConstraint, TheTwistIsThatOfTheStart) {
  const Quaternion q = turned("1 2 3", "FixedXRotation=\"true\"").orientation;
  EXPECT_NEAR(q.x() / q.w(), 0.3 / 0.9, 1e-12);
  EXPECT_GT(q.angularDistance(start), 0.5);
}

TEST(TwistConstraint, SaysWhatIsWrong) {
  const std::string points = "<EulerExplicitSolver/><MechanicalObject position=\"0 0 0\"/><UniformMass totalMass=\"1\"/>";
  expectContains(problemsOf(root(points + "<TwistConstraint FixedXRotation=\"true\"/>")), "have no orientation");
}

}  // namespace
}  // namespace stroma::test
