// SPDX-License-Identifier: LGPL-2.1-or-later
// Forces prescribed over time: moving targets, against their formulas.
#include "tests/support/field_under_test.h"

namespace stroma::test {
namespace {

std::string chain(const std::string& field, const std::string& more = "") {
  return "<Node name=\"root\" dt=\"0.01\" gravity=\"0 0 0\"><EulerImplicitSolver/><SparseLDLSolver/>"
         "<MechanicalObject position=\"0 0 0  2 0 0  2 1 0\"/><UniformMass vertexMass=\"0.1\"/>" +
         field + more + "</Node>";
}

TEST(TargetForceField, DrawsToPlacesThatMove) {
  FieldUnderTest t(chain("<TargetForceField indices=\"2 0\" targets=\"1 1 1  0 0 0\" stiffness=\"30\" "
                         "displacement=\"0 0 2\" times=\"0 1\" factors=\"1 2\"/>"),
                   "TargetForceField");
  for (const double time : {0., 0.25, 1., 5.}) {
    t.field().setTime(time);
    t.rest();
    const Vec3 moved = (1 + std::min(time, 1.)) * Vec3(0, 0, 2);
    const Vector f = t.force();
    EXPECT_LT((f[2] - 30 * (Vec3(1, 1, 1) + moved - Vec3(2, 1, 0))).norm(), 1e-12);
    EXPECT_LT((f[0] - 30 * moved).norm(), 1e-12);
    EXPECT_EQ(f[1].norm(), 0);
  }
}

TEST(TargetForceField, RampsFromRestAndMovesToAndFro) {
  FieldUnderTest t(chain("<TargetForceField indices=\"0\" stiffness=\"30\" displacement=\"0 0 2\" times=\"0 1 2 4 5\" "
                         "factors=\"0 1 0 -2 0\" period=\"5\"/>"),
                   "TargetForceField");
  struct At {
    double time, factor;
  };
  for (const At& at : {At{0, 0}, At{0.25, 0.25}, At{1, 1}, At{2, 0}, At{3, -1}, At{4, -2}, At{4.5, -1}, At{8, -1}}) {
    t.field().setTime(at.time);
    t.rest();
    EXPECT_LT((t.force()[0] - 30 * at.factor * Vec3(0, 0, 2)).norm(), 1e-12) << at.time;
  }
}

/// A node on a spring whose target moves with speed c, damped by the mass: at last it trails by rM m c / k.
TEST(TargetForceField, ANodeTrailsItsTarget) {
  Simulation simulation = simulationFromText(
      "<Node name=\"root\" dt=\"0.01\" gravity=\"0 0 0\"><EulerImplicitSolver rayleighMass=\"4\"/><SparseLDLSolver/>"
      "<MechanicalObject position=\"0 0 0\"/><UniformMass vertexMass=\"0.5\"/><TargetForceField indices=\"0\" "
      "stiffness=\"20\" displacement=\"0.3 0 0\" times=\"0 1000\" factors=\"1 1001\"/></Node>");
  for (int i = 0; i < 3000; ++i) ASSERT_FALSE(simulation.step().diverged);
  const System& system = *simulation.systems()[0];
  EXPECT_NEAR(system.v[0].x(), 0.3, 1e-9);
  EXPECT_NEAR(0.3 * (1 + simulation.time()) - system.x[0].x(), 4 * 0.5 * 0.3 / 20, 1e-9);
}

TEST(TargetForceField, BadInputIsSaid) {
  const auto says = [](const std::string& field, const std::string& words) {
    const std::string problems = problemsOf(chain(field));
    EXPECT_NE(problems.find(words), std::string::npos) << problems;
  };
  says("<TargetForceField stiffness=\"1\" indices=\"0\" targets=\"0 0 0  1 1 1\"/>", "2 places for 1 nodes");
  says("<TargetForceField stiffness=\"1\" indices=\"7\"/>", "7");
}

}  // namespace
}  // namespace stroma::test
