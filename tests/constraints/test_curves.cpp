// SPDX-License-Identifier: LGPL-2.1-or-later
// Nodes on curves, and frames that do not turn about some axes.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "framework/mechanics/frames.h"
#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

std::string chain(const std::string& constraint, double dt = 0.01) {
  return fmt::format(R"(<Node name="root" dt="{}" gravity="0 0 0"><EulerImplicitSolver/><CGLinearSolver iterations="50"
    tolerance="1e-12"/><MechanicalObject position="0 0 0  1 0 0  2 1 0"/><UniformMass totalMass="0.3"/>
    <SpringForceField springsIndices1="0 1" springsIndices2="1 2" lengths="1 1.5" stiffness="200"/>{}</Node>)",
                     dt, constraint);
}

/// x along P1 to P3 is uniform, and the place is on the parabola through the three points.
TEST(Parabola, PlacesAndVelocitiesAreExactAtStepEnds) {
  Simulation s = simulationFromText(
      chain("<ParabolicProjectiveConstraint indices='0' P1='1 0 2' P2='2 3 2' P3='5 0 2' BeginTime='0.2' EndTime='0.7'/>"));
  const System& system = *s.systems()[0];
  // y = a (X - 1)(5 - X) with y(2) = 3
  for (int n = 1; n <= 70; ++n) {
    ASSERT_FALSE(s.step().diverged);
    const double t = s.time(), along = 1 + 4 * (t - 0.2) / 0.5;
    if (n < 20) {
      EXPECT_LT(system.x[0].norm(), 2) << "free before";
      continue;
    }
    EXPECT_LT((Vec3(system.x[0]) - Vec3(along, (along - 1) * (5 - along), 2)).norm(), 1e-12) << n;
    EXPECT_LT((Vec3(system.v[0]) - Vec3(8, 8 * (6 - 2 * along), 0)).norm(), 1e-11) << n;
  }
  for (int n = 0; n < 5; ++n) ASSERT_FALSE(s.step().diverged);
  EXPECT_GT((Vec3(system.x[0]) - Vec3(5, 0, 2)).norm(), 0.1) << "free after";
}

TEST(Parabola, HoldsOutsideWhenToldSo) {
  Simulation s = simulationFromText(chain(
      "<ParabolicProjectiveConstraint indices='0 2' P1='1 0 0' P2='2 1 0' P3='3 0 0' BeginTime='0.1' EndTime='0.2' outside='hold'/>"));
  const System& system = *s.systems()[0];
  s.step();
  EXPECT_LT((Vec3(system.x[0]) - Vec3(1, 0, 0)).norm(), 1e-15);
  EXPECT_EQ(Vec3(system.v[0]), Vec3::Zero());
  for (int n = 0; n < 40; ++n) s.step();
  EXPECT_LT((Vec3(system.x[2]) - Vec3(3, 0, 0)).norm(), 1e-15);
  EXPECT_EQ(Vec3(system.v[2]), Vec3::Zero());
}

/// Three points on a line are that line.
TEST(Parabola, MayBeStraight) {
  Simulation s =
      simulationFromText(chain("<ParabolicProjectiveConstraint indices='0' P1='0 0 0' P2='1 2 2' P3='2 4 4' EndTime='1'/>"));
  for (int n = 0; n < 25; ++n) s.step();
  EXPECT_LT((Vec3(s.systems()[0]->x[0]) - 0.25 * Vec3(2, 4, 4)).norm(), 1e-13);
}

/// Without speeds the nodes start and end at rest; the place is Hermite's cubic of w = 3 u^2 - 2 u^3.
TEST(HermiteSpline, PlacesAreThoseOfTheCubicAndVelocitiesTheirSlopes) {
  const Vec3 a(0, 0, 0), da(1, 2, 0), b(1, 1, 1), db(0, 0, 3);
  const auto place = [&](double w) {
    return Vec3((1 + 2 * w) * (1 - w) * (1 - w) * a + w * (1 - w) * (1 - w) * da + w * w * (3 - 2 * w) * b - w * w * (1 - w) * db);
  };
  for (const bool with_speeds : {false, true}) {
    const double first = with_speeds ? 1.5 : 0, last = with_speeds ? 0.5 : 0;
    Simulation s = simulationFromText(
        chain(fmt::format("<HermiteSplineProjectiveConstraint indices='1' X0='0 0 0' dX0='1 2 0' X1='1 1 1' dX1='0 0 3' EndTime='0.5' "
                          "SX0='9 {}' SX1='9 {}'/>",
                          first, last)));
    const System& system = *s.systems()[0];
    const auto at = [&](double t) {
      const double u = t / 0.5;
      return place(first * u * (1 - u) * (1 - u) + u * u * (3 - 2 * u) - last * u * u * (1 - u));
    };
    for (int n = 1; n <= 50; ++n) {
      ASSERT_FALSE(s.step().diverged);
      const double t = s.time();
      EXPECT_LT((Vec3(system.x[1]) - at(t)).norm(), 1e-13) << n;
      if (n == 50) continue;
      EXPECT_LT((Vec3(system.v[1]) - (at(t + 1e-6) - at(t - 1e-6)) / 2e-6).norm(), 1e-7) << n;
    }
    const Vec3 end = last / 0.5 * db;
    EXPECT_LT((Vec3(system.v[1]) - end).norm(), 1e-12) << "the slope at the end";
  }
}

TEST(Curves, SayWhatIsWrong) {
  const auto told = [](const std::string& constraint) { return problemsOf(chain(constraint)); };
  const std::string points = "P1='0 0 0' P2='1 1 0' P3='2 0 0' ";
  expectContains(told("<ParabolicProjectiveConstraint indices='0' " + points + "BeginTime='1' EndTime='0.5'/>"), "EndTime after BeginTime");
  expectContains(told("<ParabolicProjectiveConstraint indices='9' " + points + "EndTime='1'/>"), "indices");
  expectContains(told("<ParabolicProjectiveConstraint indices='0' P1='0 0 0' P2='3 1 0' P3='2 0 0' EndTime='1'/>"),
                 "there is no parabola through it");
  expectContains(told("<ParabolicProjectiveConstraint indices='0' P1='0 0 0' P2='3 1 0' P3='0 0 0' EndTime='1'/>"), "the same place");
  expectContains(told("<HermiteSplineProjectiveConstraint indices='0' X0='0 0 0' X1='1 0 0' EndTime='1' SX0='1 2 3'/>"),
                 "SX0 has 3 numbers");
}

// ---- frames that do not turn ----

/// A torque about all axes of a frame with the inertia I turns it about the free ones only: w = t T / I.
TEST(FixedRotation, HoldsTheAxesThatItNames) {
  const auto turned = [](const std::string& attributes) {
    auto s = std::make_unique<Simulation>(sceneFromText(fmt::format(
        R"(<Node name="root" dt="0.01" gravity="0 0 0"><EulerImplicitSolver/><SparseLDLSolver/><MechanicalObject template="Rigid3"
        position="0 0 0  0 0 0 1   1 0 0  0 0 0 1"/><UniformMass totalMass="2" inertia="0.5 0.5 0.5"/>
        <ConstantForceField forces="1 0 0  1 2 3"/><FixedRotationProjectiveConstraint {}/></Node>)",
        attributes)));
    for (int n = 0; n < 10; ++n) EXPECT_FALSE(s->step().diverged);
    return s;
  };
  const auto velocity = [](const auto& s, Index frame) { return Vec3(s->systems()[0]->v[2 * frame + 1]); };
  const double t = 0.1;
  const auto all = turned("FixedXRotation='true' FixedZRotation='true'");
  for (Index frame = 0; frame < 2; ++frame) {
    EXPECT_LT((velocity(all, frame) - Vec3(0, 2 * t / 0.5, 0)).norm(), 1e-10);
    EXPECT_NEAR(all->systems()[0]->v[2 * frame].x(), t, 1e-12) << "centres are free";
    const Vec3 turn = rotationVector(orientationIn(all->systems()[0]->x, 2 * frame + 1));
    EXPECT_NEAR(turn.y(), 4 * 0.01 * 0.01 * 55, 1e-10) << "sums of the steps";
    EXPECT_LT(std::abs(turn.x()) + std::abs(turn.z()), 1e-12);
  }
  const auto one = turned("indices='1' FixedYRotation='true'");
  EXPECT_NEAR(velocity(one, 0).y(), 2 * t / 0.5, 1e-3) << "of the other frame nothing is held";
  EXPECT_EQ(velocity(one, 1).y(), 0);
  EXPECT_GT(velocity(one, 1).z(), 0.5);
}

TEST(FixedRotation, SaysWhatIsWrong) {
  expectContains(problemsOf(chain("<FixedRotationProjectiveConstraint FixedXRotation='true'/>")), "have no orientation");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
