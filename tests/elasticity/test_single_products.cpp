// SPDX-License-Identifier: LGPL-2.1-or-later
// Products in single precision are those in double precision but for the rounding, whatever the size of the numbers, wherever the
// body is and whichever force was the last. Their forces sum to zero as in double precision, and a body that is free to move has
// them only where the scene asks for them.
#include <gtest/gtest.h>

#include "framework/algebra/parallel.h"
#include "tests/support/field_under_test.h"

namespace stroma::test {
namespace {

constexpr double rounding = 5e-6;

Vector singleProduct(FieldUnderTest& t, ConstRows d, double factor = 1) {
  Vector df(t.x.count());
  t.field().addSingleProduct(d, factor, df);
  return df;
}
Vector scaled(ConstRows a, double s) {
  Vector out(a.count);
  axpy(s, a, out);
  return out;
}

bool machineHasThem() {
  __builtin_cpu_init();
  return __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq");
}

class SingleProduct : public testing::TestWithParam<std::string> {
 protected:
  FieldUnderTest t{tetrahedraScene(GetParam()), "TetrahedronFEMForceField"};
  void SetUp() override {
    if (!machineHasThem()) GTEST_SKIP() << "registers of eight doubles have products in single precision, shorter ones do not";
    t.deform(0.03);
    ASSERT_GT(t.field().cost().single, 0);
    ASSERT_LT(t.field().cost().single, t.field().cost().product);
  }
};
INSTANTIATE_TEST_SUITE_P(Methods, SingleProduct,
                         testing::Values("method=\"small\"", "method=\"large\"", "method=\"polar\"", "method=\"svd\"",
                                         "method=\"polar\" updateStiffnessMatrix=\"true\"",
                                         "method=\"svd\" updateStiffnessMatrix=\"true\" updateVolume=\"true\""));

TEST_P(SingleProduct, IsThatOfDoublePrecisionButForTheRounding) {
  const Vector exact = t.product(t.direction, -2.5), single = singleProduct(t, t.direction, -2.5);
  EXPECT_LT(relativeDifference(exact, single), rounding);
  EXPECT_GT(relativeDifference(exact, single), 1e-12) << "it is no other product at all";
}

TEST_P(SingleProduct, HasNoNetForce) {
  for (const double size : {1e-40, 1., 1e40})
    EXPECT_LT(momentumOf(t.x, singleProduct(t, scaled(t.direction, size), -2.5)).force, 1e-13) << size;
}

TEST_P(SingleProduct, TakesNumbersOfEverySize) {
  const Vector exact = t.product(t.direction);
  for (const double size : {1e-200, 1e-40, 1e40, 1e200}) {
    const Vector single = singleProduct(t, scaled(t.direction, size));
    EXPECT_LT(relativeDifference(exact, scaled(single, 1 / size)), rounding) << size;
  }
  Vector none(t.x.count());
  const Vector zero = singleProduct(t, none);
  EXPECT_EQ(dot(zero, zero), 0);
}

TEST_P(SingleProduct, DoesNotFeelWhereADirectionBegins) {
  const Vector exact = t.product(t.direction);
  Vector moved = scaled(t.direction, 1);
  for (Index i = 0; i < moved.count(); ++i) moved[i] += Vec3(1e6, -3e6, 2e6);
  EXPECT_LT(relativeDifference(exact, singleProduct(t, moved)), rounding);
}

TEST_P(SingleProduct, FollowsTheLastForce) {
  t.product(t.direction);
  const Vector before = singleProduct(t, t.direction);
  t.deform(0.05, 3);
  const Vector exact = t.product(t.direction), now = singleProduct(t, t.direction);
  EXPECT_LT(relativeDifference(exact, now), rounding);
  if (GetParam() != "method=\"small\"") {
    EXPECT_GT(relativeDifference(before, now), 1e-3);
  }
  Vector both(t.x.count());
  t.rest();
  t.field().addForceAndProduct(t.x, t.v_zero, t.direction, 1, both);
  EXPECT_LT(relativeDifference(t.product(t.direction), singleProduct(t, t.direction)), rounding);
}

TEST(SingleProducts, HaveTheSameBitsOnAnyNumberOfThreads) {
  if (!machineHasThem()) GTEST_SKIP() << "no products in single precision";
  const std::string scene =
      "<Node name=\"root\" dt=\"0.01\"><EulerImplicitSolver/><CGLinearSolver/>"
      "<RegularGridTopology name=\"grid\" n=\"21 21 21\" min=\"0 0 0\" max=\"1 1 1\"/><MechanicalObject name=\"dofs\"/>"
      "<UniformMass totalMass=\"1\"/><Node name=\"cells\"><TetrahedronSetTopologyContainer name=\"cells\"/>"
      "<Hexa2TetraTopologicalMapping input=\"@../grid\" output=\"@cells\" cutting=\"five\"/>"
      "<TetrahedronFEMForceField mstate=\"@../dofs\" topology=\"@cells\" method=\"large\"/></Node></Node>";
  FieldUnderTest t(scene, "TetrahedronFEMForceField");
  t.deform(0.03);
  t.product(t.direction);
  const Vector one = singleProduct(t, t.direction);
  setThreads(2);
  t.product(t.direction);
  const Vector two = singleProduct(t, t.direction);
  setThreads(1);
  EXPECT_EQ(std::memcmp(one.rows().data, two.rows().data, one.rows().doubles() * sizeof(double)), 0);
  EXPECT_LT(relativeDifference(t.product(t.direction), one), rounding);
}

/// A cube of 34,295 tetrahedra whose ends are pulled to opposite sides, with what holds it and what is beside it.
std::string pulledCube(const std::string& precision, const std::string& holds, const std::string& beside = "") {
  return "<Node name=\"root\" dt=\"0.01\" gravity=\"0 0 0\"><EulerImplicitSolver/>"
         "<CGLinearSolver iterations=\"25\" tolerance=\"1e-5\" " + precision + "/><Node name=\"cube\">"
         "<RegularGridTopology name=\"grid\" n=\"20 20 20\" min=\"0 0 0\" max=\"0.1 0.1 0.1\"/><MechanicalObject name=\"dofs\"/>"
         "<UniformMass totalMass=\"1\"/><BoxROI name=\"a\" box=\"0.099 -1 -1 0.101 1 1\"/>"
         "<BoxROI name=\"b\" box=\"-0.001 -1 -1 0.001 1 1\"/><ConstantForceField indices=\"@a.indices\" totalForce=\"0 1 0\"/>"
         "<ConstantForceField indices=\"@b.indices\" totalForce=\"0 -1 0\"/>" + holds +
         "<Node name=\"cells\"><TetrahedronSetTopologyContainer name=\"cells\"/>"
         "<Hexa2TetraTopologicalMapping input=\"@../grid\" output=\"@cells\" cutting=\"five\"/>"
         "<TetrahedronFEMForceField mstate=\"@../dofs\" topology=\"@cells\" method=\"large\" youngModulus=\"1e7\"/></Node></Node>" +
         beside + "</Node>";
}
Vector velocityAfterSteps(const std::string& scene) {
  Simulation simulation = simulationFromText(scene);
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(simulation.step().diverged);
  const System& system = *simulation.systems()[0];
  Vector v(system.allRows());
  copy(system.v, v);
  return v;
}
/// Of bodies whose nodes have one mass, relative to the sum of the magnitudes.
double momentum(const Vector& v) {
  Vec3 sum = Vec3::Zero();
  double magnitudes = 0;
  for (Index i = 0; i < v.count(); ++i) sum += v[i], magnitudes += Vec3(v[i]).norm();
  return sum.norm() / magnitudes;
}
bool areSame(ConstRows a, ConstRows b) {
  return a.count == b.count && std::memcmp(a.data, b.data, a.doubles() * sizeof(double)) == 0;
}

TEST(SingleProducts, KeepTheLinearMomentumOfAFreeBody) {
  const Vector single = velocityAfterSteps(pulledCube("precision=\"single\"", ""));
  EXPECT_LT(momentum(single), 1e-12);
  EXPECT_LT(momentum(velocityAfterSteps(pulledCube("", ""))), 1e-12);
  if (machineHasThem()) {
    EXPECT_FALSE(areSame(single, velocityAfterSteps(pulledCube("precision=\"double\"", ""))));
  }
}

TEST(SingleProducts, AreNotTakenByDefaultWhereABodyIsFreeToMove) {
  const std::string face = "<FixedProjectiveConstraint indices=\"@b.indices\"/>";
  const std::string sliding = "<PartialFixedProjectiveConstraint indices=\"@b.indices\" fixedDirections=\"1 0 1\"/>";
  const std::string tetrahedron =
      "<Node name=\"free\"><MechanicalObject position=\"1 0 0  2 0 0  1 1 0  1 0 1\"/><UniformMass totalMass=\"1\"/>"
      "<TetrahedronSetTopologyContainer tetrahedra=\"0 1 2 3\"/><TetrahedronFEMForceField method=\"large\"/></Node>";
  struct Case {
    const char* name;
    std::string holds, beside;
    bool is_free;
  };
  for (const Case& c : {Case{"nothing holds it", "", "", true}, Case{"a face holds it", face, "", false},
                        Case{"three nodes hold it", "<FixedProjectiveConstraint indices=\"0 19 7999\"/>", "", false},
                        Case{"it turns about an edge", "<FixedProjectiveConstraint indices=\"0 5 9 19\"/>", "", true},
                        Case{"it slides", sliding, "", true},
                        Case{"it is let go", "<FixedProjectiveConstraint indices=\"@b.indices\" endTime=\"1\"/>", "", true},
                        Case{"another body is free", face, tetrahedron, true}}) {
    SCOPED_TRACE(c.name);
    const Vector usual = velocityAfterSteps(pulledCube("", c.holds, c.beside));
    const Vector exact = velocityAfterSteps(pulledCube("precision=\"double\"", c.holds, c.beside));
    EXPECT_EQ(areSame(usual, exact), c.is_free || !machineHasThem());
    EXPECT_LT(relativeDifference(usual, exact), 1e-3);
  }
}

}  // namespace
}  // namespace stroma::test
