// SPDX-License-Identifier: LGPL-2.1-or-later
// BoxROI and SphereROI against tests of each node and cell by hand.
#include <gtest/gtest.h>

#include <set>

#include "framework/mesh/topology.h"
#include "tests/support/scene_text.h"

namespace stroma::test {
namespace {

const std::string body = R"(<RegularGridTopology name="grid" n="5 3 3" min="0 0 0" max="4 2 2"/>)";

template <class T>
const T& value(const Scene& scene, const std::string& attribute, const std::string& path = "/roi") {
  return *std::get<T*>(findComponent(*scene.root, path)->data().find(attribute)->pointer());
}
using Ints = std::vector<int>;

std::string sceneText(const std::string& roi) { return "<Node name=\"root\">" + body + roi + "</Node>"; }

template <class Inside>
void expectNodes(const Scene& scene, Inside&& inside) {
  const auto& mesh = dynamic_cast<Topology*>(findComponent(*scene.root, "/grid"))->mesh();
  Ints in, out;
  for (Index n = 0; n < mesh.nodes(); ++n) (inside(mesh.position[n]) ? in : out).push_back(n);
  ASSERT_FALSE(in.empty());
  ASSERT_FALSE(out.empty());
  EXPECT_EQ(value<Ints>(scene, "indices"), in);
  EXPECT_EQ(value<Ints>(scene, "indicesOut"), out);
  EXPECT_EQ(value<int>(scene, "nbIndices"), int(in.size()));
  EXPECT_EQ(value<std::vector<Vec3>>(scene, "pointsInROI").size(), in.size());
}

TEST(BoxROI, SelectsNodesBordersIncludedCornersInAnyOrder) {
  expectNodes(sceneFromText(sceneText(R"(<BoxROI name="roi" box="-1 0 0  2 1 1.5  4 2 2  4 2 1.9"/>)")),
              [](const Vec3& p) {
                return (p.x() <= 2 && p.y() <= 1 && p.z() <= 1) || (p.x() == 4 && p.y() == 2 && p.z() == 2);
              });
  expectNodes(sceneFromText(sceneText(R"(<BoxROI name="roi" box="2 1 1.5  -1 0 0"/>)")),
              [](const Vec3& p) { return p.x() <= 2 && p.y() <= 1 && p.z() <= 1; });
}

TEST(BoxROI, BordersHaveRoomForRoundOff) {
  ASSERT_GT(0.1 * 3, 0.3);  // where a grid of ten cells puts its fourth layer
  const auto selected = [](const std::string& roi) {
    const std::string grid = R"(<RegularGridTopology n="11 1 1" min="0 0 0" max="1 0 0"/>)";
    return value<int>(sceneFromText("<Node name=\"root\">" + grid + roi + "</Node>"), "nbIndices");
  };
  for (const auto& [count, border] : {std::pair(4, "0.3"), std::pair(7, "0.6"), std::pair(8, "0.7")})
    EXPECT_EQ(selected(std::string("<BoxROI name=\"roi\" box=\"-1 -1 -1 ") + border + " 1 1\"/>"), count) << border;
  EXPECT_EQ(selected(R"(<BoxROI name="roi" box="-1 -1 -1 0.3 1 1" exactBorder="true"/>)"), 3);
  EXPECT_EQ(selected(R"(<BoxROI name="roi" box="-1 -1 -1 0.2999999 1 1"/>)"), 3);
  EXPECT_EQ(selected(R"(<BoxROI name="roi" box="-1e9 -1e9 -1e9 0.2999999 1e9 1e9"/>)"), 3) << "a box without bounds";
  EXPECT_EQ(selected(R"(<SphereROI name="roi" centers="-1e9 0 0" radii="1000000000.2999"/>)"), 3);
  EXPECT_EQ(selected(R"(<PairBoxROI name="roi" inclusiveBox="-1 -1 -1 2 1 1" includedBox="-1 -1 -1 0.3 1 1"/>)"), 7);
  EXPECT_EQ(selected(R"(<SphereROI name="roi" centers="0 0 0" radii="0.3"/>)"), 4);
  EXPECT_EQ(selected(R"(<SphereROI name="roi" centers="0 0 0" radii="0.3" exactBorder="true"/>)"), 3);
}

TEST(BoxROI, StrictWantsAllNodesElseTheCentre) {
  const Scene strict = sceneFromText(sceneText(R"(<BoxROI name="roi" box="-0.1 -1 -1  1.6 3 3"/>)"));
  EXPECT_EQ(value<Ints>(strict, "hexahedronIndices"), (Ints{0, 4, 8, 12}));
  EXPECT_EQ(value<Ints>(strict, "hexahedronOutIndices").size(), 12u);
  const Scene centre = sceneFromText(sceneText(R"(<BoxROI name="roi" box="-0.1 -1 -1  1.6 3 3" strict="false"/>)"));
  EXPECT_EQ(value<Ints>(centre, "hexahedronIndices"), (Ints{0, 1, 4, 5, 8, 9, 12, 13}));
  EXPECT_EQ(value<std::vector<Hexahedron>>(centre, "hexahedraInROI").size(), 8u);
  const Scene off = sceneFromText(sceneText(R"(<BoxROI name="roi" box="-0.1 -1 -1  1.6 3 3" computeHexahedra="0"/>)"));
  EXPECT_TRUE(value<Ints>(off, "hexahedronIndices").empty());
}

TEST(BoxROI, OrientedBox) {
  // The parallelogram (0 0 0) (2 2 0) (1 3 0) in the plane z = 0, 1 deep to either side of it in all.
  const auto inside = [](const Vec3& p) {
    const double along = (p.x() + p.y()) / 4, across = (p.y() - p.x()) / 2;  // 0..1 each
    return along >= -1e-9 && along <= 1 + 1e-9 && across >= -1e-9 && across <= 1 + 1e-9 && std::abs(p.z()) <= 1 + 1e-9;
  };
  expectNodes(sceneFromText(sceneText(R"(<BoxROI name="roi" orientedBox="0 0 0  2 2 0  1 3 0  2"/>)")), inside);
}

TEST(SphereROI, SelectsNodesAndCells) {
  const Scene scene = sceneFromText(sceneText(R"(<SphereROI name="roi" centers="0 0 0  4 2 2" radii="1 1.5"/>)"));
  expectNodes(scene, [](const Vec3& p) { return p.norm() <= 1 || (p - Vec3(4, 2, 2)).norm() <= 1.5; });
  const Scene one = sceneFromText(sceneText(R"(<SphereROI name="roi" centers="0.5 0.5 0.5 " radii="0.9"/>)"));
  EXPECT_EQ(value<Ints>(one, "hexahedronIndices"), Ints{0});
}

TEST(Selection, LooksAtTheRestShapeOfTheState) {
  const Scene scene = sceneFromText(sceneText(
      R"(<MechanicalObject name="state" translation2="100 0 0"/><BoxROI name="roi" box="-0.1 -1 -1 0.1 3 3"/>)"));
  EXPECT_EQ(value<Ints>(scene, "indices").size(), 9u);
}

TEST(Selection, TakesPositionsAndCellsAsGiven) {
  const Scene scene = sceneFromText(R"(<Node name="root"><BoxROI name="roi" box="0 0 0 1 1 1"
    position="0.5 0.5 0.5  3 0 0  1 1 1" edges="0 1  0 2"/></Node>)");
  EXPECT_EQ(value<Ints>(scene, "indices"), (Ints{0, 2}));
  EXPECT_EQ(value<Ints>(scene, "edgeIndices"), Ints{1});
}

TEST(Selection, OrderOfTheFileDoesNotMatter) {
  const std::string roi = R"(<BoxROI name="roi" box="-0.1 -1 -1 0.1 3 3"/>)", state = R"(<MechanicalObject name="s"/>)";
  for (const std::string& text : {roi + state + body, state + body + roi, body + roi + state}) {
    const Scene scene = sceneFromText("<Node name=\"root\">" + text + "</Node>");
    EXPECT_EQ(value<Ints>(scene, "indices").size(), 9u);
  }
}

TEST(Selection, SaysWhatIsWrong) {
  expectContains(problemsOf(sceneText(R"(<BoxROI name="roi" box="9 9 9 10 10 10"/>)")),
                 "the selection is empty: none of 45 nodes is in the box; they lie in (0 0 0) to (4 2 2)");
  EXPECT_EQ(problemsOf(sceneText(R"(<BoxROI name="roi" box="9 9 9 10 10 10" allowEmpty="true"/>)")), "");
  expectContains(problemsOf(sceneText(R"(<SphereROI name="roi" centers="9 9 9" radii="1"/>)")), "is in the sphere");
  expectContains(problemsOf(sceneText(R"(<BoxROI name="roi"/>)")), "no box is given");
  expectContains(problemsOf(sceneText(R"(<BoxROI name="roi" box="0 0 0 1 1"/>)")), "box has 5 numbers");
  expectContains(problemsOf(sceneText(R"(<BoxROI name="roi" orientedBox="0 0 0 1 1 1 2 2 2 1"/>)")), "has no volume");
  expectContains(problemsOf(sceneText(R"(<SphereROI name="roi"/>)")), "no sphere is given");
  expectContains(problemsOf(sceneText(R"(<SphereROI name="roi" centers="0 0 0 1 1 1 2 2 2" radii="1 2"/>)")),
                 "2 radii for 3 centers");
  expectContains(problemsOf(R"(<Node name="root"><BoxROI name="roi" box="0 0 0 1 1 1"/></Node>)"),
                 "no nodes to select from");
  expectContains(
      problemsOf(R"(<Node name="root"><BoxROI name="roi" box="0 0 0 1 1 1" position="0 0 0" edges="0 5"/></Node>)"),
      "names node 5");
}

}  // namespace
}  // namespace stroma::test
