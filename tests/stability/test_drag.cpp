// SPDX-License-Identifier: LGPL-2.1-or-later
// The scenes of figures 5 and 6 of Nesme et al. 2005 as they stand in scenes/validation: a node is dragged through the
// body, so that elements invert, held and let go; the rest shape comes back.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace {

constexpr int release = 150;  ///< steps until the node is let go, in all these scenes

struct Drag {
  std::string scene;
  std::vector<std::string> settings;
  double size = 0.264;  ///< of the body [m]
  int steps = 600;      ///< after the release
};

double farthestFromRest(const Simulation& simulation) {
  const State& state = *simulation.states().at(0);
  double largest = 0;
  for (Index i = 0; i < state.size(); ++i)
    largest = std::max(largest, (state.x()[i] - state.rest_position[std::size_t(i)]).norm());
  return largest;
}

int invertedElements(Simulation& simulation) {
  const auto* field = dynamic_cast<const ForceField*>(findComponent(simulation.root(), "/organ/fem"));
  std::vector<double> j;
  field->cellField("J", simulation.systems().at(0)->x, j);
  return int(std::count_if(j.begin(), j.end(), [](double value) { return value < 0; }));
}

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

TEST(Drag, TetrahedraRegainTheirShape) {
  for (const char* method : {"large", "svd"})
    expectRestShape({"liver_drag.xml", {std::string("fem.method=") + method}}, true);
}

TEST(Drag, HexahedraRegainTheirShape) {
  for (const char* method : {"large", "polar", "svd"})
    for (const char* update : {"false", "true"})
      expectRestShape({"liver_drag_hexahedra.xml",
                       {std::string("fem.method=") + method, std::string("fem.updateStiffnessMatrix=") + update}},
                      true);
}

TEST(Drag, PhymulRegainsItsShape) {
  const std::string liver = STROMA_SHARED_DATA "/meshes/liver.msh";
  if (!std::filesystem::exists(liver)) GTEST_SKIP() << "the liver of the shared data is not here";
  const std::vector<std::string> settings{"loader.filename=" + liver, "mass.massDensity=0.0359",
                                          "held.indices=80 117 3 64", "drag.indices=53",
                                          "drag.movements=0 0 0  6.21655 4.633428 -1.40789  6.21655 4.633428 -1.40789"};
  expectRestShape({"liver_drag_phymul.xml", settings, 9.272, 4000}, false);
}

}  // namespace
}  // namespace stroma::test
