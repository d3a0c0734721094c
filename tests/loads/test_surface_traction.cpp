// SPDX-License-Identifier: LGPL-2.1-or-later
// Tractions per current area and per area at rest: resultants of stretched and turned surfaces, derivatives, a block
// under a Cauchy traction against its closed form, bad input.
#include <fmt/format.h>

#include <Eigen/Geometry>

#include "tests/support/field_under_test.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

const std::string type = "SurfaceTractionForceField";
const std::string positions = "0 0 0  1 0 .1  2 0 0  0 1 .2  1 1 .3  2 1 0  0 2 0  1 2 -.1  2 2 .2";
const std::string quads = "quads='0 1 4 3  1 2 5 4  3 4 7 6  4 5 8 7'";
const std::string triangles = "triangles='0 1 4  0 4 3  1 2 5  1 5 4  3 4 7  3 7 6  4 5 8  4 8 7'";

std::string scene(const std::string& cells, const std::string& attributes, const std::string& at = positions) {
  return fmt::format(R"(<Node name="root" dt="0.01" gravity="0 0 0"><EulerImplicitSolver/><EigenSparseLU/>
    <MeshTopology position="{}" {}/><MechanicalObject/><UniformMass totalMass="1"/><{} {}/></Node>)",
                     at, cells, type, attributes);
}
Vec3 sumOf(ConstRows f) {
  Vec3 sum = Vec3::Zero();
  for (Index i = 0; i < f.count; ++i) sum += f[i];
  return sum;
}

/// A flat square of 2 x 2, stretched to 3 x 1 and turned: the traction keeps its direction and takes the new area.
TEST(SurfaceTraction, GrowsWithTheCurrentAreaAndKeepsItsDirection) {
  const std::string flat = "0 0 0  1 0 0  2 0 0  0 1 0  1 1 0  2 1 0  0 2 0  1 2 0  2 2 0";
  const Vec3 traction(3, -1, 5);
  for (const std::string& cells : {quads, triangles}) {
    FieldUnderTest current(scene(cells, "traction='3 -1 5'", flat), type);
    FieldUnderTest rest(scene(cells, "traction='3 -1 5' area='rest'", flat), type);
    EXPECT_LT((sumOf(current.force()) - 4 * traction).norm(), 1e-13);
    Mat3 f = Eigen::AngleAxisd(1.1, Vec3(1, 2, -1).normalized()).toRotationMatrix();
    f.col(0) *= 1.5, f.col(1) *= 0.5;
    for (Index i = 0; i < 9; ++i) current.x[i] = rest.x[i] = f * Vec3(current.x[i]);
    EXPECT_LT((sumOf(current.force()) - 3 * traction).norm(), 1e-13);
    EXPECT_LT((sumOf(rest.force()) - 4 * traction).norm(), 1e-13);
    EXPECT_FALSE(rest.field().traits().has_stiffness);
    EXPECT_NEAR(rest.field().energy(rest.x), -dot(rest.force(), rest.x), 1e-12);
  }
}

TEST(SurfaceTraction, TheExactTangentIsTheForcesDerivative) {
  for (const std::string& cells : {quads, triangles}) {
    FieldUnderTest exact(scene(cells, "traction='3 -1 5' tangent='exact'"), type);
    FieldUnderTest symmetric(scene(cells, "traction='3 -1 5'"), type);
    EXPECT_FALSE(exact.field().traits().symmetric);
    EXPECT_TRUE(exact.field().traits().exact_tangent);
    EXPECT_TRUE(symmetric.field().traits().symmetric);
    EXPECT_FALSE(symmetric.field().traits().exact_tangent);
    exact.deform(0.1), symmetric.deform(0.1);
    EXPECT_EQ(relativeDifference(exact.force(), symmetric.force()), 0);
    EXPECT_LT(relativeDifference(exact.product(exact.direction), exact.differenceOfForces(1e-6)), 1e-8);
    expectMatrixOfProducts(exact), expectMatrixOfProducts(symmetric);
    expectSymmetricProducts(symmetric);
    // d.K d has the symmetric part alone
    EXPECT_NEAR(dot(symmetric.direction, symmetric.product(symmetric.direction)),
                dot(symmetric.direction, exact.product(symmetric.direction)), 1e-12);
  }
}

/// NeoHookean, stretched by l along the traction and by q across, has the Cauchy stresses (mu (l_i^2 - 1) + lambda
/// ln J)/J: that across is zero, that along the traction per current area; per area at rest it is that times q^2.
TEST(SurfaceTraction, ABlockUnderACauchyTraction) {
  const double mu = 1000, lambda = 2000;
  for (const bool current : {true, false}) {
    for (const std::string tangent : {"exact", "symmetric"}) {
      const double traction = 800;
      Simulation simulation = simulationFromText(fmt::format(
          R"(<Node name="root" dt="1" gravity="0 0 0">
  <StaticSolver newton_iterations="60" relative_residual_tolerance_threshold="1e-11"/><EigenSparseLU/>
  <RegularGridTopology name="grid" n="3 3 3" min="0 0 0" max="1 1 1"/><MechanicalObject/><UniformMass totalMass="1"/>
  <HexahedronHyperelasticityFEMForceField materialName="NeoHookean" mu="1000" lambda="2000"/>
  <SurfaceTractionForceField traction="{} 0 0" min="1 0 0" max="1 1 1" area="{}" tangent="{}"/>
  <BoxROI name="x" box="-1 -1 -1 0.001 2 2"/><BoxROI name="y" box="-1 -1 -1 2 0.001 2"/>
  <BoxROI name="z" box="-1 -1 -1 2 2 0.001"/>
  <PartialFixedProjectiveConstraint indices="@x.indices" fixedDirections="1 0 0"/>
  <PartialFixedProjectiveConstraint indices="@y.indices" fixedDirections="0 1 0"/>
  <PartialFixedProjectiveConstraint indices="@z.indices" fixedDirections="0 0 1"/></Node>)",
          traction, current ? "current" : "rest", tangent));
      const StepReport report = simulation.step();
      ASSERT_TRUE(report.newton_converged) << report.reason;
      const Vec3 corner = simulation.systems()[0]->x[26];
      const double l = corner.x(), q = corner.y();
      EXPECT_NEAR(corner.z(), q, 1e-9);
      const double j = l * q * q, along = mu * (l * l - 1) + lambda * std::log(j);
      EXPECT_NEAR(mu * (q * q - 1) + lambda * std::log(j), 0, 1e-5);
      EXPECT_NEAR(along / (current ? j : l), traction, 1e-5);
      EXPECT_GT(std::abs(j - l), 0.05) << "the areas are the same: nothing was tested";
    }
  }
}

TEST(SurfaceTraction, ChangesOverTime) {
  FieldUnderTest t(scene(quads, "keyTimes='0 2' keyTractions='0 0 0  0 0 4'"), type);
  t.field().setTime(1.5);
  const double area = sumOf(t.force()).z() / 3;
  t.field().setTime(5);
  EXPECT_NEAR(sumOf(t.force()).z(), 4 * area, 1e-13);
  EXPECT_GT(area, 4);
}

TEST(SurfaceTraction, SaysWhatIsWrong) {
  const auto problems = [](const std::string& attributes) { return problemsOf(scene(quads, attributes)); };
  expectContains(problems(""), "there is no traction");
  expectContains(problems("traction='1 0 0' keyTimes='0 1' keyTractions='0 0 0 1 0 0'"), "both given");
  expectContains(problems("keyTimes='0 1'"), "keyTimes and keyTractions are not given together");
  expectContains(problems("traction='1 0 0' quadIndices='9'"), "quadIndices[0] is 9");
  expectContains(problems("traction='1 0 0' min='8 8 8' max='9 9 9'"), "no face of the mesh is loaded");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
