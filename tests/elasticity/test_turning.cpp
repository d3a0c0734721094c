// SPDX-License-Identifier: LGPL-2.1-or-later
// Stresses that turn with their elements, which the warped tangent leaves out and may be asked to add.
#include "framework/mechanics/turns_stresses.h"
#include "tests/support/field_under_test.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

TurnsStresses& turningOf(FieldUnderTest& t) {
  auto* const turning = dynamic_cast<TurnsStresses*>(&t.field());
  EXPECT_TRUE(turning && turning->keepTurning(true));
  return *turning;
}

/// With all of it the tangent is the derivative of the force.
TEST(Turning, MakesTheWarpedTangentExact) {
  FieldUnderTest t(tetrahedraScene("method=\"svd\""), "TetrahedronFEMForceField");
  t.deform(0.1);
  const Vector difference = t.differenceOfForces(1e-6 * t.typicalEdge());
  EXPECT_GT(relativeDifference(t.product(t.direction), difference), 1e-2) << "the warped tangent is good enough: nothing was tested";
  turningOf(t).addTurning(1);
  EXPECT_LT(relativeDifference(t.product(t.direction), difference), 1e-6);
  expectMatrixOfProducts(t);
  expectSymmetricProducts(t);
}

/// Half of it is half of the difference, and without it products have the bits that they had before.
TEST(Turning, IsAddedInParts) {
  FieldUnderTest t(tetrahedraScene("method=\"svd\""), "TetrahedronFEMForceField");
  t.deform(0.1);
  const Vector warped = t.product(t.direction);
  TurnsStresses& turning = turningOf(t);
  const Vector none = t.product(t.direction);
  EXPECT_EQ(relativeDifference(warped, none), 0);
  turning.addTurning(0.5);
  const Vector half = t.product(t.direction);
  turning.addTurning(1);
  const Vector whole = t.product(t.direction);
  Vector mean(t.x.count());
  axpy(0.5, warped, mean), axpy(0.5, whole, mean);
  EXPECT_LT(relativeDifference(half, mean), 1e-13);
  EXPECT_GT(relativeDifference(warped, whole), 1e-2);
  Vector both(t.x.count()), separate = t.force();
  axpy(1.5, whole, separate);
  t.field().addForceAndProduct(t.x, t.v_zero, t.direction, 1.5, both);
  EXPECT_LT(relativeDifference(separate, both), 1e-13);
  turning.addTurning(0);
  EXPECT_EQ(relativeDifference(warped, t.product(t.direction)), 0);
}

/// Other methods have none, nor has a field whose tangent the scene names.
TEST(Turning, IsOfOneMethod) {
  for (const char* attributes : {"method='large'", "method='small'", "method='svd' tangent='warped'", "method='svd' tangent='exact'"}) {
    FieldUnderTest t(tetrahedraScene(attributes), "TetrahedronFEMForceField");
    auto* const turning = dynamic_cast<TurnsStresses*>(&t.field());
    EXPECT_FALSE(turning && turning->keepTurning(true)) << attributes;
  }
}

/// Elements that are flat, inverted or crushed have finite products, with something added. A mirror image is a switching point, of
/// which nothing is: two of its principal stretches cancel.
TEST(Turning, IsFiniteInEveryShape) {
  FieldUnderTest t(tetrahedraScene("method=\"svd\""), "TetrahedronFEMForceField");
  TurnsStresses& turning = turningOf(t);
  for (const Vec3& stretches : {Vec3(1, 1, -1), Vec3(1, 1, -0.5), Vec3(1.2, 0.9, -2), Vec3(1, 1, 0), Vec3(0, 0, 0)}) {
    t.rest();
    for (Index i = 0; i < t.x.count(); ++i) t.x[i] = stretches.cwiseProduct(Vec3(t.x[i]));
    turning.addTurning(0);
    const Vector warped = t.product(t.direction);
    turning.addTurning(1);
    const Vector product = t.product(t.direction);
    EXPECT_TRUE(std::isfinite(dot(product, product)));
    if (stretches[2] != -1) EXPECT_GT(relativeDifference(warped, product), 1e-2) << "nothing was added: " << stretches.transpose();
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
