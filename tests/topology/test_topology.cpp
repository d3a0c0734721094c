// SPDX-License-Identifier: LGPL-2.1-or-later
// Topologies in scenes: what they hold, who answers a search, and what they say when something is wrong.
#include <gtest/gtest.h>

#include <algorithm>

#include "framework/mesh/topology.h"
#include "tests/support/scene_text.h"

namespace stroma::test {
namespace {

const Mesh& meshAt(const Scene& scene, const std::string& path) {
  const auto* topology = dynamic_cast<Topology*>(findComponent(*scene.root, path));
  if (!topology) throw std::runtime_error("no topology at " + path);
  return topology->mesh();
}

const std::string one_tetrahedron = R"(position="0 0 0  1 0 0  0 1 0  0 0 1" tetrahedra="0 1 2 3")";

TEST(MeshTopology, TakesListsAndTheirOtherNames) {
  const Scene scene = sceneFromText(R"(<Node name="root"><MeshTopology name="m" points="0 0 0 1 0 0 0 1 0 0 0 1"
    tetras="0 1 2 3" lines="0 1 1 2" triangles="0 1 2"/></Node>)");
  const Mesh& mesh = meshAt(scene, "/m");
  EXPECT_EQ(mesh.nodes(), 4);
  EXPECT_EQ(mesh.tetrahedra, (std::vector<Tetrahedron>{{0, 1, 2, 3}}));
  EXPECT_EQ(mesh.edges, (std::vector<Edge>{{0, 1}, {1, 2}}));
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}}));
  EXPECT_EQ(mesh.derivedTables(), 0);
}

TEST(MeshTopology, ReadsAGmshFile) {
  const Scene scene = sceneFromText("<Node name=\"root\"><MeshTopology name=\"m\" filename=\"" STROMA_SOURCE_DIR
                                    "/scenes/meshes/organ_600.msh\"/></Node>");
  EXPECT_GT(meshAt(scene, "/m").tetrahedra.size(), 500u);
  expectContains(
      problemsOf("<Node name=\"root\"><MeshTopology name=\"m\" position=\"0 0 0\" filename=\"" STROMA_SOURCE_DIR
                 "/scenes/meshes/organ_600.msh\"/></Node>"),
      "both filename and position are given");
}

TEST(MeshTopology, SaysWhatIsWrong) {
  const auto with = [](const std::string& attributes) {
    return problemsOf("<Node name=\"root\"><MeshTopology name=\"m\" " + attributes + "/></Node>");
  };
  expectContains(with("tetrahedra=\"0 1 2 3\""), "there are no nodes");
  expectContains(with("position=\"0 0 0 1 0 0 0 1 0 0 0 1\" tetrahedra=\"0 1 2 4\""),
                 "tetrahedron 0 names node 4, but the mesh has 4 nodes (0 to 3)");
  expectContains(with("position=\"0 0 0 1 0 0 0 1 0 0 0 1\" tetrahedra=\"0 1 2 2\""), "names node 2 twice");
  expectContains(with(one_tetrahedron + " prisms=\"0 1 2 3 4 5\""), "prism 0 names node 5, but the mesh has 4 nodes (0 to 3)");
  expectContains(with(one_tetrahedron + " nbPoints=\"7\""), "nbPoints is 7, but there are 4 positions");
}

TEST(MeshTopology, WarnsOfAnInvertedCell) {
  const Scene scene = sceneFromText(R"(<Node name="root">
    <MeshTopology name="m" position="0 0 0 1 0 0 0 1 0 0 0 1" tetrahedra="0 2 1 3"/></Node>)");
  expectContains(scene.diagnostics.text(), "the mesh has no volume");
  expectContains(scene.diagnostics.text(), "1 inverted cells (0)");
}

TEST(Container, TakesPositionsFromTheState) {
  for (const char* order : {"state first", "container first"}) {
    const std::string state = R"(<MechanicalObject name="s" position="0 0 0 1 0 0 0 1 0 0 0 1"/>)";
    const std::string container = R"(<TetrahedronSetTopologyContainer name="t" tetrahedra="0 1 2 3"/>)";
    const Scene scene =
        sceneFromText("<Node name=\"root\">" + (order[0] == 's' ? state + container : container + state) + "</Node>");
    EXPECT_EQ(meshAt(scene, "/t").nodes(), 4) << order;
  }
}

TEST(Container, TakesPositionsThatTheStateLinks) {
  for (const char* name : {"position", "rest_position"})
    for (const char* order : {"state first", "container first"}) {
      const std::string source = R"(<MeshTopology name="source" position="0 0 0 1 0 0 2 0 0"/><Node name="body">)";
      const std::string state = std::string("<MechanicalObject name='s' ") + name + "='@../source.position'/>";
      const std::string container = R"(<MeshTopology name="t" edges="0 1 1 2"/>)";
      const Scene scene = sceneFromText("<Node name=\"root\">" + source +
                                        (order[0] == 's' ? state + container : container + state) + "</Node></Node>");
      EXPECT_EQ(meshAt(scene, "/body/t").nodes(), 3) << name << ", " << order;
      EXPECT_EQ(scene.diagnostics.text(), "") << name << ", " << order;
    }
  // neither has any: said of the container, whichever comes first
  for (const char* text : {"<MeshTopology name='t' edges='0 1'/><MechanicalObject name='s'/>",
                           "<MechanicalObject name='s'/><MeshTopology name='t' edges='0 1'/>"}) {
    const std::string told = problemsOf(std::string("<Node name='root'>") + text + "</Node>");
    expectContains(told, "/t");
    expectContains(told, "there are no nodes");
    EXPECT_EQ(told.find("circle"), std::string::npos) << told;
  }
}

TEST(Container, MakesFacesWhenAsked) {
  const Scene scene =
      sceneFromText("<Node name=\"root\"><TetrahedronSetTopologyContainer name=\"a\" " + one_tetrahedron +
                    " createTriangleArray=\"true\"/><Node name=\"n\">"
                    "<TetrahedronSetTopologyContainer name=\"b\" " +
                    one_tetrahedron + "/></Node></Node>");
  EXPECT_EQ(meshAt(scene, "/a").triangles.size(), 4u);
  EXPECT_EQ(meshAt(scene, "/n/b").triangles.size(), 0u);
}

TEST(Container, EachKindWantsItsCells) {
  const struct {
    const char *type, *cells;
  } kinds[] = {{"Edge", "edges=\"0 1\""},
               {"Triangle", "triangles=\"0 1 2\""},
               {"Quad", "quads=\"0 1 2 3\""},
               {"Tetrahedron", "tetrahedra=\"0 1 2 4\""},
               {"Hexahedron", "hexahedra=\"0 1 2 3 4 5 6 7\""}};
  const std::string points = " name=\"c\" position=\"0 0 0 1 0 0 1 1 0 0 1 0 0 0 1 1 0 1 1 1 1 0 1 1\" ";
  for (const auto& kind : kinds) {
    const std::string start = "<Node name=\"root\"><" + std::string(kind.type) + "SetTopologyContainer" + points;
    EXPECT_EQ(problemsOf(start + kind.cells + "/></Node>"), "");
    expectContains(problemsOf(start + "/></Node>"), "there are no ");
  }
}

TEST(Grid, NodesAndCells) {
  const Scene scene =
      sceneFromText(R"(<Node name="root"><RegularGridTopology name="g" n="4 3 2" min="-1 0 2" max="2 1 2.7"/></Node>)");
  const Mesh& mesh = meshAt(scene, "/g");
  ASSERT_EQ(mesh.nodes(), 24);
  ASSERT_EQ(mesh.hexahedra.size(), 6u);
  EXPECT_TRUE(mesh.position[1 + 4 * 1 + 12 * 1].isApprox(Vec3(0, 0.5, 2.7)));
  EXPECT_EQ(mesh.position.back(), Vec3(2, 1, 2.7));  // to the last bit
  EXPECT_EQ(mesh.hexahedra[4], (Hexahedron{5, 6, 10, 9, 17, 18, 22, 21}));
  EXPECT_NEAR(mesh.report().volume, 3 * 1 * 0.7, 1e-12);
  EXPECT_TRUE(mesh.report().inverted.empty());
  EXPECT_TRUE(mesh.quads.empty());
}

TEST(Grid, EveryWayToWriteIt) {
  const std::string ways[] = {R"(n="3 2 2" min="0 0 0" max="2 1 1")",
                              R"(nx="3" ny="2" nz="2" xmin="0" xmax="2" ymin="0" ymax="1" zmin="0" zmax="1")",
                              R"(cellWidth="1" min="0 0 0" max="2 1 1")",
                              R"(n="3 2 2" min="0 0 0" max="1 0.5 0.5" scale="2")"};
  std::vector<Vec3> first;
  for (const std::string& way : ways) {
    const Scene scene = sceneFromText("<Node name=\"root\"><RegularGridTopology name=\"g\" " + way + "/></Node>");
    EXPECT_EQ(scene.diagnostics.text(), "");
    const Mesh& mesh = meshAt(scene, "/g");
    if (first.empty()) first = mesh.position;
    EXPECT_EQ(mesh.position, first) << way;
    EXPECT_EQ(mesh.hexahedra.size(), 2u);
  }
}

TEST(Grid, FlatAndThinGrids) {
  const Scene scene = sceneFromText(R"(<Node name="root">
    <RegularGridTopology name="flat" n="3 1 4" min="0 0 0" max="2 0 3" computeTriangleList="true"/>
    <Node name="a"><RegularGridTopology name="line" n="1 5 1" min="0 0 0" max="0 4 0"/></Node>
    <Node name="b"><RegularGridTopology name="solid" n="3 3 3" min="0 0 0" max="1 1 1" computeQuadList="1"
                                        computeEdgeList="1"/></Node></Node>)");
  EXPECT_EQ(meshAt(scene, "/flat").quads.size(), 6u);
  EXPECT_EQ(meshAt(scene, "/flat").triangles.size(), 12u);
  EXPECT_EQ(meshAt(scene, "/a/line").edges.size(), 4u);
  EXPECT_EQ(meshAt(scene, "/b/solid").quads.size(), 36u);
  EXPECT_EQ(meshAt(scene, "/b/solid").edges.size(), 54u);
}

TEST(Grid, SaysWhatIsWrong) {
  const auto with = [](const std::string& attributes) {
    return problemsOf("<Node name=\"root\"><RegularGridTopology name=\"g\" " + attributes + "/></Node>");
  };
  expectContains(with(R"(n="2 2 2" min="0 0 0" max="1 1 -1")"), "the box is -1 long in z for 2 nodes");
  expectContains(with(R"(n="2 2 0" min="0 0 0" max="1 1 1")"), "n");
  expectContains(with(R"(n="1 1 1" min="0 0 0" max="1 1 1")"), "a single node");
  expectContains(with(R"(n="99999 99999 99999" min="0 0 0" max="1 1 1")"), "too large");
  expectContains(with(R"(n="2 2 2" nx="3" min="0 0 0" max="1 1 1")"), "both n and nx are given");
  expectContains(with(R"(cellWidth="1e-300" min="0 0 0" max="1 1 1")"), "cellWidth");
  const Scene scene = sceneFromText(R"(<Node name="root"><RegularGridTopology name="g"/></Node>)");
  expectContains(scene.diagnostics.text(), "a unit cube is used");
}

const std::string grid = R"(<RegularGridTopology name="grid" n="3 4 3" min="0 0 0" max="2 3 2"/>)";

std::string cutScene(const std::string& child) {
  return "<Node name=\"root\">" + grid + "<Node name=\"body\">" + child + "</Node></Node>";
}

/// Asks what a force field would: the one topology of the node.
const Topology* found(const Scene& scene) { return scene.root->findChild("body")->find<Topology>(nullptr, false); }

TEST(Mapping, FillsTheContainerInAnyOrder) {
  const std::string container = R"(<TetrahedronSetTopologyContainer name="tets"/>)";
  const std::string linked = R"(<Hexa2TetraTopologicalMapping name="cut" input="@../grid" output="@tets"/>)";
  const std::string beside = R"(<Hexa2TetraTopologicalMapping name="cut" input="@../grid"/>)";
  for (const std::string& text : {container + linked, linked + container, container + beside, beside + container}) {
    const Scene scene = sceneFromText(cutScene(text));
    const Topology* topology = found(scene);
    ASSERT_NE(topology, nullptr);
    EXPECT_EQ(topology->name(), "tets");
    EXPECT_EQ(topology->mesh().tetrahedra.size(), 12u * 6);
    EXPECT_EQ(topology->mesh().nodes(), 36);
    EXPECT_NEAR(topology->mesh().report().volume, 12, 1e-12);
    EXPECT_TRUE(topology->mesh().hexahedra.empty());
  }
}

TEST(Mapping, TheIdentityHasAllCellsOfTheOther) {
  const Scene scene = sceneFromText(cutScene(R"(<HexahedronSetTopologyContainer name="same"/>
    <IdentityTopologicalMapping input="@../grid" output="@same"/>)"));
  EXPECT_EQ(meshAt(scene, "/body/same").hexahedra, meshAt(scene, "/grid").hexahedra);
  EXPECT_EQ(meshAt(scene, "/body/same").hexahedra.size(), 12u);
  EXPECT_EQ(meshAt(scene, "/body/same").nodes(), 36);
}

TEST(Mapping, IsTheTopologyOfItsNodeWithoutAContainer) {
  const Scene scene = sceneFromText(cutScene(R"(<Hexa2TetraTopologicalMapping name="cut" cutting="five"/>)"));
  ASSERT_NE(found(scene), nullptr);
  EXPECT_EQ(found(scene)->name(), "cut");
  EXPECT_EQ(found(scene)->mesh().tetrahedra.size(), 12u * 5);
}

TEST(Mapping, TenCoverTheBodyTwice) {
  const Scene scene = sceneFromText(cutScene(R"(<TetrahedronSetTopologyContainer name="tets"/>
    <Hexa2TetraTopologicalMapping name="cut" input="@../grid" output="@tets" cutting="ten"/>)"));
  EXPECT_EQ(found(scene)->mesh().overlap, 2);
  EXPECT_NEAR(found(scene)->mesh().report().volume, 12, 1e-12);
  EXPECT_EQ(findComponent(*scene.root, "/body/cut")->data().find("stiffnessScale")->print(), "0.5");
}

TEST(Mapping, WarnsOfCracksAndRefusesNonsense) {
  const Scene scene = sceneFromText(cutScene(R"(<Hexa2TetraTopologicalMapping name="cut" cutting="five1"/>)"));
  expectContains(scene.diagnostics.text(), "20 inner faces are cut along different diagonals");
  EXPECT_EQ(sceneFromText(cutScene(R"(<Hexa2TetraTopologicalMapping swapping="1"/>)")).diagnostics.text(), "");
  expectContains(problemsOf(cutScene(R"(<Hexa2TetraTopologicalMapping cutting="seven"/>)")),
                 "six, five, five1, five2, ten");
  expectContains(problemsOf(cutScene(R"(<Hexa2TetraTopologicalMapping cutting="ten" swapping="1"/>)")),
                 "swapping mirrors");
  expectContains(problemsOf("<Node name=\"root\"><Hexa2TetraTopologicalMapping/></Node>"),
                 "there is no topology to cut");
  expectContains(problemsOf("<Node name=\"root\"><MeshTopology name=\"m\" " + one_tetrahedron +
                            "/><Node name=\"n\"><Hexa2TetraTopologicalMapping/></Node></Node>"),
                 "/m has no hexahedra");
}

TEST(Mapping, LinksToItsListsSeeThem) {
  const Scene scene = sceneFromText(cutScene(R"(<TetrahedronSetTopologyContainer name="tets"/>
    <Hexa2TetraTopologicalMapping name="cut" input="@../grid" output="@tets"/>
    <Node name="copy"><MeshTopology name="m" position="@../tets.position" tetrahedra="@../tets.tetrahedra"/></Node>)"));
  EXPECT_EQ(meshAt(scene, "/body/copy/m").tetrahedra.size(), 72u);
}

}  // namespace
}  // namespace stroma::test
