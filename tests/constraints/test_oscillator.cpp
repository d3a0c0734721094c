// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace {

std::string scene(const std::string& constraint) {
  return "<Node name=\"root\" dt=\"0.01\" gravity=\"0 0 0\"><EulerImplicitSolver/><CGLinearSolver iterations=\"50\" "
         "tolerance=\"1e-10\"/><MechanicalObject position=\"0 0 0  1 0 0  2 1 0\"/><UniformMass totalMass=\"0.3\"/>"
         "<SpringForceField springsIndices1=\"0 1\" springsIndices2=\"1 2\" lengths=\"1 1.5\" stiffness=\"200\"/>"
         "<OscillatorProjectiveConstraint " +
         constraint + "/></Node>";
}

TEST(Oscillator, PositionsAndVelocitiesAreExactAtStepEnds) {
  Simulation s = simulationFromText(scene("oscillators=\"2  2 1 0.5  0.1 0 -0.2  7 0.3   0  0 0 0  0 0.1 0  5 0\""));
  for (int n = 1; n <= 200; ++n) {
    ASSERT_FALSE(s.step().diverged);
    const System& system = *s.systems()[0];
    const double t = s.time();
    const Vec3 x(2 + 0.1 * std::sin(7 * t + 0.3), 1, 0.5 - 0.2 * std::sin(7 * t + 0.3));
    const Vec3 v(0.7 * std::cos(7 * t + 0.3), 0, -1.4 * std::cos(7 * t + 0.3));
    ASSERT_LT((system.x[2] - x).norm(), 1e-15);
    ASSERT_LT((system.v[2] - v).norm(), 1e-14);
    ASSERT_LT((system.x[0] - Vec3(0, 0.1 * std::sin(5 * t), 0)).norm(), 1e-15);
  }
  EXPECT_GT((s.systems()[0]->x[1] - Vec3(1, 0, 0)).norm(), 1e-3) << "the free node is not carried along";
}

TEST(Oscillator, ListedNodesTurn) {
  Simulation s = simulationFromText(scene(
      "indices=\"0 2\" rotation=\"0 0 0.01\" centre=\"1 0 0\" translation=\"0 0 0.02\" pulsation=\"3\" phase=\"1\""));
  for (int n = 0; n < 50; ++n) ASSERT_FALSE(s.step().diverged);
  const double now = std::sin(3 * s.time() + 1);
  const System& system = *s.systems()[0];
  EXPECT_LT((system.x[0] - Vec3(0, -0.01 * now, 0.02 * now)).norm(), 1e-15);
  EXPECT_LT((system.x[2] - Vec3(2 - 0.01 * now, 1 + 0.01 * now, 0.02 * now)).norm(), 1e-15);
}

TEST(Oscillator, SaysWhatIsWrong) {
  const auto expect = [](const std::string& constraint, const std::string& words) {
    const std::string problems = problemsOf(scene(constraint));
    EXPECT_NE(problems.find(words), std::string::npos) << constraint << ": " << problems;
  };
  expect("", "no node is named");
  expect("oscillators=\"1 2 3\"", "nine for each node");
  expect("oscillators=\"1.5  2 1 0  0.1 0 0  7 0\"", "no index of a node");
  expect("oscillators=\"7  2 1 0  0.1 0 0  7 0\"", "7");
  expect("oscillators=\"1  2 1 0  0.1 0 0  7 0\" indices=\"0\"", "both given");
}

}  // namespace
}  // namespace stroma::test
