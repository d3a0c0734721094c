// SPDX-License-Identifier: LGPL-2.1-or-later
// Newton's and Euler's laws (Nesme et al. 2005, sections 2.2 and 3.1): internal forces sum to zero with any B; their
// torques vanish when B is up to date.
#include <algorithm>
#include <filesystem>

#include "tests/support/field_under_test.h"

namespace stroma::test {
namespace {

void expectMomentumLaws(const ElasticBody& body, const Variant& variant, double noise) {
  for (unsigned seed : {1u, 2u, 3u}) {
    SCOPED_TRACE(body.name + " " + variant.name);
    FieldUnderTest t(body.scene(variant.attributes), body.type);
    t.deform(noise, seed);
    std::vector<double> j;
    t.field().cellField("J", t.x, j);
    ASSERT_GT(*std::min_element(j.begin(), j.end()), 0) << "inverted elements have a test of their own";
    const Momentum momentum = momentumOf(t.x, t.force());
    if (variant.is("nodal")) {  // rows of one element in different frames: ghost forces
      EXPECT_GT(momentum.force, 1e-4);
      EXPECT_GT(momentum.torque, 1e-4);
      continue;
    }
    EXPECT_LT(momentum.force, 1e-12) << "Newton's law";
    if (variant.torque_free)
      EXPECT_LT(momentum.torque, 1e-12) << "Euler's law";
    else  // a constant B whose stress and stretch have different axes
      EXPECT_GT(momentum.torque, 1e-5) << "a constant B breaks Euler's law";
    if (seed == 1)
      ::testing::Test::RecordProperty("torque " + body.name + variant.name, std::to_string(momentum.torque));
  }
}

TEST(MomentumLaws, LargeRandomDeformation) {
  forEachElasticVariant(
      false, [](const ElasticBody& body, const Variant& variant) { expectMomentumLaws(body, variant, 0.04); });
}
void expectMomentumLawsOn(const std::string& mesh) {
  ElasticBody body = bodyOfTetrahedra();
  body.scene = [&](const std::string& attributes) { return tetrahedraScene(attributes, mesh); };
  for (const Variant& variant : body.variants(false)) expectMomentumLaws(body, variant, 0.02);
}
TEST(MomentumLaws, OrganUnderLargeRandomDeformation) {
  expectMomentumLawsOn(STROMA_SOURCE_DIR "/scenes/meshes/organ_5000.msh");
}
TEST(MomentumLaws, LiverUnderLargeRandomDeformation) {
  const std::string liver = STROMA_SHARED_DATA "/meshes/liver.msh";
  if (!std::filesystem::exists(liver)) GTEST_SKIP() << "no real liver beside the project: " << liver;
  expectMomentumLawsOn(liver);
}

/// Inverted and flat elements keep the laws too: they hold for each element, whatever its shape.
TEST(MomentumLaws, HoldWhenElementsAreInverted) {
  forEachElasticVariant(false, [](const ElasticBody& body, const Variant& variant) {
    if (variant.is("nodal")) return;
    FieldUnderTest t(body.scene(variant.attributes), body.type);
    t.deform(1.0);
    std::vector<double> j;
    t.field().cellField("J", t.x, j);
    ASSERT_GT(std::count_if(j.begin(), j.end(), [](double v) { return v < 0; }), 20);
    const Momentum momentum = momentumOf(t.x, t.force());
    EXPECT_LT(momentum.force, 1e-12);
    if (variant.b_current || variant.is("green") || ((body.tetrahedra || body.quadratic) && variant.is("svd"))) {
      EXPECT_LT(momentum.torque, 1e-12);
    }
  });
}

/// The sum of the products of all rigid translations is zero, for any tangent.
TEST(MomentumLaws, ProductsToo) {
  forEachElasticVariant(true, [](const ElasticBody& body, const Variant& variant) {
    if (variant.is("nodal")) return;
    FieldUnderTest t(body.scene(variant.attributes), body.type);
    t.deform(0.2);
    const Vector df = t.product(t.direction);
    EXPECT_LT(momentumOf(t.x, df).force, 1e-12);
  });
}

}  // namespace
}  // namespace stroma::test
