// SPDX-License-Identifier: LGPL-2.1-or-later
// Products in single precision are those in double precision but for the rounding, whatever the size of the numbers, wherever the
// body is and whichever force was the last.
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

}  // namespace
}  // namespace stroma::test
