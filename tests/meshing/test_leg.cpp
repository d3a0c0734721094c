// SPDX-License-Identifier: LGPL-2.1-or-later
// The leg of the examples: its stored mesh, labels through both loaders, and its condensed solution against Newton's.
#include <cmath>

#include "framework/mechanics/state.h"
#include "framework/mesh/mesh_loader.h"
#include "tests/meshing/meshing_fixture.h"
#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace {

const std::string stored = STROMA_SOURCE_DIR "/scenes/meshes/leg.msh";

TEST(Leg, TheStoredMeshIsWatertightAndOfGoodShape) {
  double angle = 0;
  const GmshFile file = readGmsh(stored);
  const auto regions = regionsOf(file, angle);
  ASSERT_EQ(regions.size(), 3u);
  EXPECT_GT(angle, 8);
  for (const auto& [label, region] : regions) EXPECT_EQ(region.bad_edges, 0) << "label " << label;
  // voxels of 2 mm that make_leg.py printed: 229658 of soft tissue, 21136 of the tibia, 4272 of the fibula
  EXPECT_NEAR(regions.at(1).volume, 229658 * 8e-9, 0.01 * 229658 * 8e-9);
  EXPECT_NEAR(regions.at(2).volume, 21136 * 8e-9, 0.01 * 21136 * 8e-9);
  EXPECT_NEAR(regions.at(3).volume, 4272 * 8e-9, 0.01 * 4272 * 8e-9);
  EXPECT_EQ(file.group_names.at({3, 2}), "tibia");
}

using Labels = std::vector<std::pair<std::array<double, 3>, int>>;

/// The labels of a loader by the centres of its cells, whatever their order.
Labels labelsOf(const std::string& loader, const std::string& file) {
  const Scene scene =
      sceneFromText("<Node name=\"root\"><" + loader + " name=\"loader\" filename=\"" + file + "\"/></Node>");
  const auto* component = dynamic_cast<MeshLoader*>(findComponent(*scene.root, "/loader"));
  const auto& groups = *std::get<std::vector<int>*>(component->data().find("tetrahedraGroups")->pointer());
  const Mesh& mesh = component->mesh();
  EXPECT_EQ(groups.size(), mesh.tetrahedra.size());
  Labels labels;
  for (std::size_t c = 0; c < groups.size(); ++c) {
    Vec3 centre = Vec3::Zero();
    for (const Index n : mesh.tetrahedra[c]) centre += mesh.position[n];
    labels.push_back(
        {{std::round(centre.x() * 1e6), std::round(centre.y() * 1e6), std::round(centre.z() * 1e6)}, groups[c]});
  }
  std::sort(labels.begin(), labels.end());
  return labels;
}

TEST_F(MeshCommand, LabelsSurviveBothFormats) {
  if (!makeLeg("leg.mhd")) GTEST_SKIP() << "no Python with numpy";
  for (const char* output : {"leg.msh", "leg.vtu"})
    ASSERT_EQ(stroma(std::string("mesh leg.mhd --scale 0.001 --cell-size 0.03 --distance 0.004 -o ") + output).code, 0);
  const Labels msh = labelsOf("MeshGmshLoader", (folder_ / "leg.msh").string());
  EXPECT_EQ(msh, labelsOf("MeshVTKLoader", (folder_ / "leg.vtu").string()));
  std::map<int, int> count;
  for (const auto& [centre, label] : msh) ++count[label];
  EXPECT_EQ(count.size(), 3u);
}

TEST(Leg, TheCondensedSolutionIsNewtons) {
  const auto pushed = [](const std::string& solver) {
    std::string text = readText(STROMA_SOURCE_DIR "/scenes/examples/leg.xml");
    const auto replace = [&text](const std::string& from, const std::string& to) {
      const auto at = text.find(from);
      ASSERT_NE(at, std::string::npos) << from;
      text.replace(at, from.size(), to);
    };
    replace("<CondensedStaticSolver name=\"solver\"/>", solver);
    replace("../meshes/leg.msh", stored);
    text.erase(text.find("<VTKExporter"), text.find("/>", text.find("<VTKExporter")) + 2 - text.find("<VTKExporter"));
    Simulation simulation = simulationFromText(text);
    for (int k = 0; k < 25; ++k) simulation.step();
    const auto* state = dynamic_cast<State*>(findComponent(*simulation.scene().root, "/leg/dofs"));
    std::vector<Vec3> x;
    for (Index n = 0; n < state->size(); ++n) x.emplace_back(state->x()[n]);
    return x;
  };
  const GmshFile file = readGmsh(stored);
  const auto condensed = pushed("<CondensedStaticSolver name=\"solver\"/>");
  const auto newton = pushed("<StaticSolver/><SparseLDLSolver/>");
  ASSERT_EQ(condensed.size(), newton.size());
  double largest = 0, difference = 0;
  for (const Triangle& t : file.mesh.triangles)  // the surfaces
    for (const Index n : t) {
      largest = std::max(largest, (newton[n] - file.mesh.position[n]).norm());
      if (file.groups.triangles[&t - file.mesh.triangles.data()] == 1)
        difference = std::max(difference, (newton[n] - condensed[n]).norm());
    }
  EXPECT_GT(largest, 0.001);  // half of the push is 1.5 mm
  EXPECT_LT(largest, 0.01);
  EXPECT_LT(difference, 1e-8 * largest);
}

}  // namespace
}  // namespace stroma::test
