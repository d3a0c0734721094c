// SPDX-License-Identifier: LGPL-2.1-or-later
// Bodies whose coordinates are 1e8 times their cells: of the 16 digits of a force 8 are those of rounded positions, and no more may be
// lost. What is computed from products of coordinates and not from their differences would lose all.
#include <fmt/format.h>

#include <optional>

#include "tests/support/field_under_test.h"
#include "tests/support/force_field_examples.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// All states of points of a scene moved by (d, -d, d/2) where it is made.
std::string moved(std::string scene, double d) {
  const std::string state = "<MechanicalObject", way = fmt::format(" translation=\"{:.17g} {:.17g} {:.17g}\"", d, -d, d / 2);
  for (std::size_t at = scene.find(state); at != std::string::npos; at = scene.find(state, at + 1)) {
    const std::string element = scene.substr(at, scene.find('>', at) - at);
    if (element.find("template") == std::string::npos) scene.insert(at + state.size(), way);
  }
  return scene;
}

/// Without what holds nodes: regions would have to move too.
std::string withoutHolds(std::string scene) {
  for (const std::string word : {"ROI ", "ProjectiveConstraint "})
    for (std::size_t at = scene.find(word); at != std::string::npos; at = scene.find(word, at)) {
      const std::size_t start = scene.rfind('<', at), end = scene.find("/>", at);
      scene.erase(start, end + 2 - start), at = start;
    }
  return scene;
}

/// By how much the force on a deformed body is another when it is so far away; nothing where it depends on the place.
std::optional<double> lostFarAway(const std::string& scene, const std::string& type) {
  constexpr double far = 1e8;
  FieldUnderTest near(scene, type);
  near.deform(0.05);
  const Vector force = near.force();
  const double edge = near.typicalEdge();
  FieldUnderTest beside(moved(scene, 3 * edge), type);
  beside.deform(0.05);
  if (!(relativeDifference(force, beside.force()) < 1e-8)) return {};
  FieldUnderTest away(moved(scene, far * edge), type);
  away.deform(0.05);
  return relativeDifference(force, away.force());
}

constexpr double most = 1e-5;  // strains of a tenth, positions off by 1e-8 of a cell

TEST(FarFromOrigin, EveryForceFieldKeepsEightDigits) {
  modules().openAll();
  int tested = 0;
  for (const ComponentEntry* entry : factory().entries()) {
    if (!dynamic_cast<ForceField*>(factory().make(entry->type).get())) continue;
    const std::string example = exampleOf(entry->type), type = fieldOf(example, entry->type);
    if (FieldUnderTest t(example, type); !t.field().state().hasPointsOnly()) continue;
    try {
      const auto lost = lostFarAway(withoutHolds(example), type);
      if (!lost) continue;
      EXPECT_LT(*lost, most) << type;
      ++tested;
    } catch (const SceneError&) {  // something is asked for that is held
    }
  }
  EXPECT_GT(tested, 20);
}

TEST(FarFromOrigin, EveryElasticVariantKeepsEightDigits) {
  int tested = 0;
  forEachElasticVariant(true, [&](const ElasticBody& body, const Variant& variant) {
    if (variant.is("small")) return;  // pure linear elasticity feels how positions are turned
    const auto lost = lostFarAway(body.scene(variant.attributes), body.type);
    ASSERT_TRUE(lost);
    EXPECT_LT(*lost, most);
    ++tested;
  });
  EXPECT_GT(tested, 30);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
