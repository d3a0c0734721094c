// SPDX-License-Identifier: LGPL-2.1-or-later
// Loads given by formulas: values at nodes over time, integrals over faces and cells against closed forms, a bar under
// a body force, and formulas that cannot be read.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "tests/support/field_under_test.h"

namespace stroma::test {
namespace {

const std::string type = "FormulaForceField";

std::string scene(const std::string& mesh, const std::string& attributes) {
  return "<Node name=\"root\" dt=\"0.01\" gravity=\"0 0 0\"><EulerImplicitSolver/><CGLinearSolver/>" + mesh +
         "<MechanicalObject/><UniformMass totalMass=\"1\"/><" + type + " " + attributes + "/></Node>";
}
const std::string square =
    "<MeshTopology position=\"0 0 0  2 0 0  2 1 0  0 1 0\" quads=\"0 1 2 3\" edges=\"0 1  1 2  2 3  3 0\"/>";
const std::string two_triangles = "<MeshTopology position=\"0 0 0  2 0 0  2 1 0  0 1 0\" triangles=\"0 1 2  0 2 3\"/>";

Vec3 sumOf(ConstRows f) {
  Vec3 sum = Vec3::Zero();
  for (Index i = 0; i < f.count; ++i) sum += f[i];
  return sum;
}

TEST(FormulaForceField, NodesGetTheFormulaAtTheirPlaceAtRestAndTheTime) {
  FieldUnderTest t(scene(square, "force=\"x + 2*y*t; sin(2*pi*t); x > 1 ? -3 : exp(-y)\""), type);
  t.deform(0.3);
  for (const double time : {0., 0.2, 1.7}) {
    t.field().setTime(time);
    const Vector f = t.force();
    const double wave = std::sin(2 * std::numbers::pi * time);
    for (Index i = 0; i < 4; ++i) {
      const Vec3& p = t.field().state().rest_position[i];
      const Vec3 expected(p.x() + 2 * p.y() * time, wave, p.x() > 1 ? -3 : std::exp(-p.y()));
      EXPECT_LT((Vec3(f[i]) - expected).norm(), 1e-14 * expected.norm()) << i << ", " << time;
    }
  }
  EXPECT_TRUE(t.field().traits().time_dependent);
  FieldUnderTest listed(scene(square, "indices=\"2\" force=\"1; x; y\""), type);
  EXPECT_FALSE(listed.field().traits().time_dependent) << "its formulas have no t";
  EXPECT_EQ(sumOf(listed.force()), Vec3(1, 2, 1));
}

/// Resultant and moment of a traction on [0, 2] x [0, 1].
TEST(FormulaForceField, ATractionIsIntegrated) {
  for (const std::string& mesh : {square, two_triangles}) {
    FieldUnderTest t(scene(mesh, "per=\"area\" force=\"0; 0; 3*x - y + 2\""), type);
    const Vector f = t.force();
    EXPECT_NEAR(sumOf(f).z(), 9, 1e-13);  // 6 - 1 + 4
    double moment = 0;
    for (Index i = 0; i < 4; ++i) moment += t.field().state().rest_position[i].x() * f[i].z();
    EXPECT_NEAR(moment, 11, 1e-13);  // 8 - 1 + 4
  }
  FieldUnderTest t(scene(square, "per=\"area\" force=\"0; x^2*y^2; 0\""), type);
  EXPECT_NEAR(sumOf(t.force()).y(), 8. / 9, 1e-13);
}

/// E u'' = -c x^2 with u(0) = 0 and u'(L) = 0: nodes of linear elements lie on the solution when the load is integrated.
TEST(FormulaForceField, ABarUnderABodyForce) {
  const double young = 2000, length = 1.5, c = 10;
  Simulation simulation = simulationFromText(
      R"(<Node name="root" dt="1" gravity="0 0 0"><StaticSolver/><SparseLDLSolver/>
  <RegularGridTopology name="grid" n="6 2 2" min="0 0 0" max="1.5 0.2 0.3"/>
  <MechanicalObject/><UniformMass totalMass="1"/>
  <HexahedronFEMForceField method="small" youngModulus="2000" poissonRatio="0"/>
  <FormulaForceField per="volume" force="10*x^2; 0; 0"/>
  <BoxROI name="held" box="-1 -1 -1 0.001 1 1"/><FixedProjectiveConstraint indices="@held.indices"/></Node>)");
  ASSERT_TRUE(simulation.step().newton_converged);
  const State& state = *simulation.states()[0];
  for (Index i = 0; i < state.size(); ++i) {
    const double x = state.rest_position[i].x();
    const double u = c / (3 * young) * (std::pow(length, 3) * x - std::pow(x, 4) / 4);
    EXPECT_NEAR(simulation.systems()[0]->x[i].x() - x, u, 1e-9) << x;
  }
}

TEST(FormulaForceField, WhatCannotBeReadIsNamed) {
  const auto problems = [](const std::string& attributes) { return problemsOf(scene(square, attributes)); };
  expectContains(problems("force=\"1; 2\""), "force has 2 formulas");
  expectContains(problems("force=\"1; 2*u; 0\""), "the formula ' 2*u' of the y component cannot be read");
  expectContains(problems("force=\"1; ; 0\""), "of the y component cannot be read");
  expectContains(problems("force=\"ln(x - 1); 0; 0\""), "at node 0");
  expectContains(problems("per=\"area\" indices=\"1\" force=\"1; 0; 0\""), "indices are nodes");
  expectContains(problems("per=\"volume\" force=\"1; 0; 0\""), "the mesh has no volume");
}

}  // namespace
}  // namespace stroma::test
