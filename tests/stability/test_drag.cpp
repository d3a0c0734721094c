// SPDX-License-Identifier: LGPL-2.1-or-later
// The scenes of figures 5 and 6 of Nesme et al. 2005 as they stand in scenes/validation: a node is dragged through the
// body, so that elements invert, held and let go; the rest shape comes back.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "tests/stability/dragged.h"
#include "tools/checks/result_doubts.h"

namespace stroma::test {
namespace {

constexpr int release = 150;  ///< steps until the node is let go, in all these scenes

struct Drag {
  std::string scene;
  std::vector<std::string> settings;
  double size = 0.264;  ///< of the body [m]
  int steps = 600;      ///< after the release
};

void expectRestShape(const Drag& drag, bool inverts) {
  std::vector<Override> overrides;
  for (const std::string& text : drag.settings) overrides.push_back(Override::parse("/organ/" + text));
  Simulation simulation(
      loadScene(STROMA_SOURCE_DIR "/scenes/validation/" + drag.scene, overrides, factory(), modules()));
  for (int step = 0; step < release; ++step) ASSERT_FALSE(simulation.step().diverged) << step;
  EXPECT_GT(farthestFromRest(simulation), 0.3 * drag.size) << "nothing was dragged, so nothing is shown";
  if (inverts) {
    EXPECT_GT(invertedElements(simulation), 0) << "nothing was inverted, so nothing is shown";
  }
  int step = 0;
  while (farthestFromRest(simulation) > 1e-6 * drag.size && step < drag.steps) {
    ASSERT_FALSE(simulation.step().diverged) << step;
    ++step;
  }
  EXPECT_LE(farthestFromRest(simulation), 1e-6 * drag.size) << step << " steps after the release";
}

/// An element whose B follows its shape resists to being flattened: none inverts.
std::string updateOf(bool update) { return std::string("fem.updateStiffnessMatrix=") + (update ? "true" : "false"); }

/// The liver of the paper's figures instead of the example organ.
Drag liverDrag(const std::string& scene, std::vector<std::string> settings, const std::string& density, int steps) {
  for (const std::string& text :
       {std::string("loader.filename=" STROMA_SHARED_DATA "/meshes/liver.msh"), "mass.massDensity=" + density,
        std::string("held.indices=80 117 3 64"), std::string("drag.indices=53"),
        std::string("drag.movements=0 0 0  6.21655 4.633428 -1.40789  6.21655 4.633428 -1.40789")})
    settings.push_back(text);
  return {scene, settings, 9.272, steps};
}
bool liverIsHere() { return std::filesystem::exists(STROMA_SHARED_DATA "/meshes/liver.msh"); }

TEST(Drag, TetrahedraRegainTheirShape) {
  for (const char* method : {"large", "svd"})
    expectRestShape({"liver_drag.xml", {std::string("fem.method=") + method}}, true);
}

/// With the frame `polar` and a constant B some inverted elements of this body hold each other where they are: the run
/// then says which.
TEST(Drag, AShapeThatIsKeptIsNamed) {
  Simulation simulation(loadScene(STROMA_SOURCE_DIR "/scenes/validation/liver_drag.xml",
                                  {Override::parse("/organ/fem.method=polar")}, factory(), modules()));
  for (int step = 0; step < 1000; ++step) ASSERT_FALSE(simulation.step().diverged) << step;
  if (farthestFromRest(simulation) < 1e-6 * 0.264) return;
  const std::vector<std::string> sentences = doubtsOf(simulation);
  ASSERT_EQ(sentences.size(), 1u);
  for (const char* word : {"/organ/fem", "inverted", "tetrahedron ", "J = "})
    EXPECT_NE(sentences[0].find(word), std::string::npos) << sentences[0];
}

TEST(Drag, TheLiverRegainsItsShape) {
  if (!liverIsHere()) GTEST_SKIP() << "the liver of the shared data is not here";
  for (const char* method : {"large", "polar", "svd"})
    for (const bool update : {false, true}) {
      SCOPED_TRACE(fmt::format("{} {}", method, update ? "B" : "no B"));
      expectRestShape(
          liverDrag("liver_drag.xml", {std::string("fem.method=") + method, updateOf(update)}, "0.0359", 600), !update);
    }
}

TEST(Drag, HexahedraRegainTheirShape) {
  for (const char* method : {"large", "polar", "svd"})
    for (const bool update : {false, true})
      expectRestShape({"liver_drag_hexahedra.xml", {std::string("fem.method=") + method, updateOf(update)}}, !update);
}

TEST(Drag, PhymulRegainsItsShape) {
  if (!liverIsHere()) GTEST_SKIP() << "the liver of the shared data is not here";
  expectRestShape(liverDrag("liver_drag_phymul.xml", {}, "0.0359", 4000), false);
}

}  // namespace
}  // namespace stroma::test
