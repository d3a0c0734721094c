// SPDX-License-Identifier: LGPL-2.1-or-later
// Points on cells, tubes around edges, and which parts of a mesh those of another are; with the mappings that carry them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "framework/mechanics/frames.h"
#include "framework/mesh/topology.h"
#include "tests/support/scene_text.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

const Mesh& meshOf(const Scene& scene, const std::string& path) {
  return dynamic_cast<const Topology&>(*findComponent(*scene.root, path)).mesh();
}
std::vector<int> listOf(const Scene& scene, const std::string& path, const std::string& name) {
  return *std::get<std::vector<int>*>(findComponent(*scene.root, path)->data().find(name)->pointer());
}

const std::string cells =
    R"(<MeshTopology name="cells" position="0 0 0  2 0 0  2 2 0  0 2 0  0 0 2  2 0 2  2 2 2  0 2 2" edges="0 1  6 7"
    triangles="0 1 2" quads="0 1 2 3" tetrahedra="0 1 3 4" hexahedra="0 1 2 3 4 5 6 7"/>)";

TEST(Mesh2Point, PointsStandInTheOrderOfThePartsOfTheMesh) {
  const Scene scene = sceneFromText(
      "<Node name='root'>" + cells +
      "<Node name='points'><PointSetTopologyContainer name='cloud'/><Mesh2PointTopologicalMapping input='@../cells' output='@cloud' "
      "pointBaryCoords='0 0 0  0 0 0.5' edgeBaryCoords='0.25 0 0' triangleBaryCoords='0.5 0.25 0' quadBaryCoords='0.25 0.75 0' "
      "tetraBaryCoords='0.1 0.2 0.3' hexaBaryCoords='0.25 0.5 0.75'/></Node></Node>");
  const std::vector<Vec3>& points = meshOf(scene, "/points/cloud").position;
  ASSERT_EQ(points.size(), 8u * 2 + 2 + 1 + 1 + 1 + 1);
  EXPECT_LT((points[12] - Vec3(2, 2, 2)).norm(), 1e-15);
  EXPECT_LT((points[13] - Vec3(2, 2, 2.5)).norm(), 1e-15);
  EXPECT_LT((points[16] - Vec3(0.5, 0, 0)).norm(), 1e-15);
  EXPECT_LT((points[17] - Vec3(1.5, 2, 2)).norm(), 1e-15);
  EXPECT_LT((points[18] - Vec3(1.5, 0.5, 0)).norm(), 1e-15);
  EXPECT_LT((points[19] - Vec3(0.5, 1.5, 0)).norm(), 1e-15) << "on the quad where its coordinates say";
  EXPECT_LT((points[20] - Vec3(0.2, 0.4, 0.6)).norm(), 1e-15);
  EXPECT_LT((points[21] - Vec3(0.5, 1, 1.5)).norm(), 1e-15);
}

TEST(Mesh2Point, CellsAreCopiedBetweenTheFirstPoints) {
  const Scene scene = sceneFromText("<Node name='root'>" + cells +
                                    "<Node name='points'><Mesh2PointTopologicalMapping name='m' input='@../cells' copyEdges='true' "
                                    "copyTriangles='true' copyTetrahedra='true' pointBaryCoords='0 0 0  1 1 1'/></Node></Node>");
  const Mesh& mesh = meshOf(scene, "/points/m");
  EXPECT_EQ(mesh.edges, (std::vector<Edge>{{0, 2}, {12, 14}}));
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 2, 4}}));
  EXPECT_EQ(mesh.tetrahedra, (std::vector<Tetrahedron>{{0, 2, 6, 8}}));
}

/// A force on a point is shared by the nodes as its place is.
TEST(Mesh2Point, CarriesPlacesAndForces) {
  Simulation simulation = simulationFromText(
      R"(<Node name="root" dt="0.1" gravity="0 0 0"><EulerExplicitSolver/>
      <MeshTopology name="net" position="0 0 0  1 0 0  0 1 0" triangles="0 1 2"/><MechanicalObject/><UniformMass totalMass="3"/>
      <Node name="points"><Mesh2PointTopologicalMapping input="@../net" pointBaryCoords="0 0 1" triangleBaryCoords="0.5 0.25 0"/>
      <MechanicalObject name="seen"/><Mesh2PointMechanicalMapping/><ConstantForceField indices="3" forces="0 0 8"/></Node></Node>)");
  simulation.step();
  const State& nodes = *simulation.states().at(0);
  const double h2 = 0.01;
  EXPECT_LT((Vec3(nodes.x()[0]) - Vec3(0, 0, 2 * h2)).norm(), 1e-14);
  EXPECT_LT((Vec3(nodes.x()[1]) - Vec3(1, 0, 4 * h2)).norm(), 1e-14);
  EXPECT_LT((Vec3(nodes.x()[2]) - Vec3(0, 1, 2 * h2)).norm(), 1e-14);
  const auto& seen = dynamic_cast<const State&>(*findComponent(simulation.root(), "/points/seen"));
  ASSERT_EQ(seen.size(), 4);
  EXPECT_LT((Vec3(seen.x()[1]) - Vec3(1, 0, 1 + 4 * h2)).norm(), 1e-14) << "with its offset";
  EXPECT_LT((Vec3(seen.x()[3]) - Vec3(0.5, 0.25, (0.25 * 2 + 0.5 * 4 + 0.25 * 2) * h2)).norm(), 1e-14);
  EXPECT_NEAR(seen.v()[3].z(), 10 * (0.25 * 2 + 0.5 * 4 + 0.25 * 2) * h2, 1e-13) << "without it";
}

TEST(Mesh2Point, SaysWhatIsWrong) {
  const auto told = [](const std::string& attributes) {
    return problemsOf("<Node name='root'>" + cells + "<Mesh2PointTopologicalMapping input='@cells' " + attributes + "/></Node>");
  };
  expectContains(told(""), "no part of the input gives a point");
  expectContains(told("edgeBaryCoords='0.5 0 0' copyEdges='true'"), "copyEdges needs a point of each node");
  expectContains(told("pointBaryCoords='0 0 0' edgeBaryCoords='0.3 0 0' splitTetrahedra='true'"), "the middle of each edge");
  expectContains(told("pointBaryCoords='0 0 0' edgeBaryCoords='0.5 0 0' splitTetrahedra='true' copyTetrahedra='true'"), "one of them");
  expectContains(problemsOf("<Node name='root'><EulerExplicitSolver/><MechanicalObject position='0 0 0'/><UniformMass totalMass='1'/>"
                            "<Node name='n'><MechanicalObject/><Mesh2PointMechanicalMapping/></Node></Node>"),
                 "there is no Mesh2PointTopologicalMapping");
}

// ---- tubes ----

const std::string tube =
    R"(<Node name="root" dt="0.01" gravity="0 0 0"><EulerExplicitSolver/><MeshTopology name="line" edges="0 1"/>
    <MechanicalObject name="frames" template="Rigid3" position="0 0 0  0 0 0 1   3 1 0  0 0 0.6 0.8"/>
    <UniformMass totalMass="2" inertia="0.5 0.5 0.5"/><Node name="tube"><QuadSetTopologyContainer name="quads"/>
    <Edge2QuadTopologicalMapping nbPointsOnEachCircle="4" radius="0.5" input="@../line" output="@quads"/>
    <MechanicalObject name="skin"/><TubularMapping nbPointsOnEachCircle="4" radius="0.5" {}/>{}</Node></Node>)";

TEST(Tube, CirclesStandAcrossTheFramesAndQuadsGoRound) {
  Simulation simulation = simulationFromText(fmt::format(fmt::runtime(tube), "", ""));
  const Mesh& mesh = dynamic_cast<const Topology&>(*findComponent(simulation.root(), "/tube/quads")).mesh();
  EXPECT_EQ(mesh.quads, (std::vector<Quad>{{0, 4, 5, 1}, {1, 5, 6, 2}, {2, 6, 7, 3}, {3, 7, 4, 0}}));
  const auto& skin = dynamic_cast<const State&>(*findComponent(simulation.root(), "/tube/skin"));
  simulation.step();
  const Vec3 along(0.28, 0.96, 0), across(-0.96, 0.28, 0);  // x and y of the frame turned by 2 atan(0.75) about z
  for (int j = 0; j < 4; ++j) {
    const double angle = std::numbers::pi / 2 * j;
    const Vec3 first = 0.5 * Vec3(0, std::cos(angle), std::sin(angle));
    const Vec3 second = Vec3(3, 1, 0) + 0.5 * (std::cos(angle) * across + std::sin(angle) * Vec3::UnitZ());
    for (const std::vector<Vec3>* places : {&mesh.position, &skin.rest_position}) {
      EXPECT_LT(((*places)[std::size_t(j)] - first).norm(), 1e-14);
      EXPECT_LT(((*places)[std::size_t(4 + j)] - second).norm(), 1e-14);
    }
    EXPECT_LT((Vec3(skin.x()[4 + j]) - second).norm(), 1e-14);
    EXPECT_NEAR((second - Vec3(3, 1, 0)).dot(along), 0, 1e-15);
  }
}

/// A force on a point of the skin pushes and turns its frame.
TEST(Tube, AForceOnItTurnsItsFrame) {
  Simulation simulation = simulationFromText(fmt::format(fmt::runtime(tube), "", "<ConstantForceField indices='0' forces='3 0 0'/>"));
  simulation.step();
  const auto& frames = dynamic_cast<const State&>(*findComponent(simulation.root(), "/frames"));
  EXPECT_LT((Vec3(frames.v()[0]) - 0.01 * Vec3(3, 0, 0)).norm(), 1e-14);
  EXPECT_LT((Vec3(frames.v()[1]) - 0.01 * Vec3(0, 0, -1.5) / 0.5).norm(), 1e-14) << "0.5 y x 3 x";
  EXPECT_EQ(Vec3(frames.v()[2]), Vec3::Zero());
}

TEST(Tube, APeakEndsInAPoint) {
  const auto radii = [](const std::string& peak) {
    Simulation simulation = simulationFromText(fmt::format(fmt::runtime(tube), peak, ""));
    simulation.step();
    const auto& skin = dynamic_cast<const State&>(*findComponent(simulation.root(), "/tube/skin"));
    return std::pair(Vec3(skin.x()[0]).norm(), (Vec3(skin.x()[4]) - Vec3(3, 1, 0)).norm());
  };
  EXPECT_NEAR(radii("peak='1'").first, 0, 1e-15);
  EXPECT_NEAR(radii("peak='1'").second, 0.5, 1e-15);
  EXPECT_NEAR(radii("peak='2'").second, 0.25, 1e-15);
  EXPECT_NEAR(radii("peak='-1'").first, 0.5, 1e-15);
  EXPECT_NEAR(radii("peak='-1'").second, 0, 1e-15);
}

TEST(Tube, MayBeAnEllipseOfSomeEdgesTurnedInward) {
  const Scene scene = sceneFromText(
      R"(<Node name="root"><MeshTopology name="line" edges="0 1  1 2"/><MechanicalObject template="Rigid3"
      position="0 0 0 0 0 0 1  1 0 0 0 0 0 1  2 0 0 0 0 0 1"/><Node name="tube"><Edge2QuadTopologicalMapping name="m"
      nbPointsOnEachCircle="4" radius="0.5" radiusFocal="0.2" focalAxis="0 2 0" edgeList="1" flipNormals="true" input="@../line"/>
      </Node></Node>)");
  const Mesh& mesh = meshOf(scene, "/tube/m");
  ASSERT_EQ(mesh.quads.size(), 4u);
  EXPECT_EQ(mesh.quads[0], (Quad{5, 9, 8, 4}));
  EXPECT_LT((mesh.position[0] - Vec3(0, 0, -0.5)).norm(), 1e-15) << "Y = Z x X";
  EXPECT_LT((mesh.position[1] - Vec3(0, 0.2, 0)).norm(), 1e-15);
}

TEST(Tube, SaysWhatIsWrong) {
  expectContains(problemsOf(R"(<Node name="root"><MeshTopology name="line" position="0 0 0  1 0 0" edges="0 1"/>
      <Edge2QuadTopologicalMapping nbPointsOnEachCircle="4" radius="0.5" input="@line"/></Node>)"),
                 "there are no rigid frames");
  expectContains(problemsOf(fmt::format(fmt::runtime(tube), "peak='0'", "<FixedProjectiveConstraint indices='99'/>")), "indices");
}

// ---- parts ----

TEST(SubsetTopology, FindsNodesByPlaceAndCellsByNodes) {
  const Scene scene = sceneFromText(
      "<Node name='root'>" + cells +
      R"(<MeshTopology name="part" position="2 2 0  0 0 0  2 0 0" triangles="2 1 0"/>
      <SubsetTopologicalMapping name="m" input="@cells" output="@part" handleTriangles="true"/></Node>)");
  EXPECT_EQ(listOf(scene, "/m", "pointD2S"), (std::vector<int>{2, 0, 1}));
  EXPECT_EQ(listOf(scene, "/m", "pointS2D"), (std::vector<int>{1, 2, 0, -1, -1, -1, -1, -1}));
  EXPECT_EQ(listOf(scene, "/m", "triangleD2S"), (std::vector<int>{0}));
  EXPECT_EQ(listOf(scene, "/m", "triangleS2D"), (std::vector<int>{0}));
  expectContains(problemsOf("<Node name='root'>" + cells + "<MeshTopology name='part' position='2 2 0.1'/>" +
                            "<SubsetTopologicalMapping input='@cells' output='@part'/></Node>"),
                 "node 0 of /part is no node of /cells");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
