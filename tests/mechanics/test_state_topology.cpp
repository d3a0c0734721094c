// SPDX-License-Identifier: LGPL-2.1-or-later
// Which mesh belongs to a state: the rule of state_topology.h, as scenes show it.
#include "framework/mechanics/state_topology.h"

#include <fmt/format.h>

#include "tests/support/scene_text.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

const std::string four_nodes = "position='0 0 0  1 0 0  0 1 0  0 0 1'";
const std::string five_nodes = "position='0 0 0  1 0 0  0 1 0  0 0 1  1 1 1'";

std::string mesh(const std::string& name, const std::string& position, const std::string& cells) {
  return fmt::format("<MeshTopology name='{}' {} {}/>", name, position, cells);
}

std::string scene(const std::string& content) { return "<Node name='root'>" + content + "</Node>"; }

/// What /dofs or another state has for its own mesh.
std::string topologyNamed(const std::string& xml, const std::string& path = "/dofs") {
  const Scene loaded = sceneFromText(xml);
  const Topology* found = topologyOf(*dynamic_cast<State*>(findComponent(*loaded.root, path)));
  return found ? found->path() : "none";
}

const std::string tetrahedron = "tetrahedra='0 1 2 3'", triangles = "triangles='0 2 1  0 1 3'";

TEST(StateTopology, IsTheLastOfItsNodeAndTheFirstOfANodeAbove) {
  const std::string both = mesh("a", four_nodes, tetrahedron) + mesh("b", four_nodes, triangles);
  EXPECT_EQ(topologyNamed(scene(both + "<MechanicalObject name='dofs'/>")), "/b");
  const std::string below = "<Node name='n'><MechanicalObject name='dofs' " + four_nodes + "/></Node>";
  EXPECT_EQ(topologyNamed(scene(both + below), "/n/dofs"), "/a");
}

TEST(StateTopology, HasTheNodesOfTheState) {
  const std::string a = mesh("a", four_nodes, tetrahedron), b = mesh("b", five_nodes, triangles);
  const std::string dofs = "<MechanicalObject name='dofs' " + four_nodes + "/>";
  EXPECT_EQ(topologyNamed(scene(a + b + dofs)), "/a");
  EXPECT_EQ(topologyNamed(scene(b + a + dofs)), "/a");
  EXPECT_EQ(topologyNamed(scene(a + "<Node name='n'>" + b + dofs + "</Node>"), "/n/dofs"), "/a");
  EXPECT_EQ(topologyNamed(scene(b + dofs)), "none");
}

TEST(StateTopology, NodesComeFromAGridAndCellsFromTheContainerCutFromIt) {
  const std::string text = scene(R"(<RegularGridTopology name="grid" n="3 3 3" min="0 0 0" max="1 1 1"/>
    <MechanicalObject name="dofs"/>
    <TetrahedronSetTopologyContainer name="tets"/>
    <Hexa2TetraTopologicalMapping name="cut" input="@grid" output="@tets"/>
    <DiagonalMass name="mass" massDensity="2"/>
    <TetrahedronFEMForceField youngModulus="100" poissonRatio="0.3" method="small"/>)");
  const Scene loaded = sceneFromText(text);
  EXPECT_EQ(loaded.diagnostics.text(), "");
  const auto& state = *dynamic_cast<State*>(findComponent(*loaded.root, "/dofs"));
  EXPECT_EQ(state.size(), 27);
  EXPECT_EQ(topologyOf(state)->name(), "tets");
  EXPECT_EQ(topologiesOf(state).size(), 2u);
  EXPECT_EQ(firstTopology(state, false)->name(), "grid");
}

/// A mass of the cells that it finds: of the tetrahedron 1/6, of the triangles 1.
TEST(StateTopology, TheAttributeDecides) {
  const auto massOf = [](const std::string& attribute) {
    const Scene loaded = sceneFromText(scene(mesh("a", four_nodes, tetrahedron) + mesh("b", four_nodes, triangles) +
                                             "<MechanicalObject name='dofs'/><DiagonalMass name='mass' "
                                             "massDensity='1' " +
                                             attribute + "/>"));
    return dynamic_cast<Mass*>(findComponent(*loaded.root, "/mass"))->totalMass();
  };
  EXPECT_NEAR(massOf(""), 1, 1e-15);
  EXPECT_NEAR(massOf("topology='@b'"), 1, 1e-15);
  EXPECT_NEAR(massOf("topology='@a'"), 1. / 6, 1e-15);
}

TEST(StateTopology, OnesThatDoNotFitAreNamedWithTheAttribute) {
  const std::string six = "position='0 0 0  1 0 0  0 1 0  0 0 1  1 1 1  2 2 2'";
  const std::string text = problemsOf(scene(mesh("a", five_nodes, tetrahedron) + mesh("b", six, triangles) +
                                          "<MechanicalObject name='dofs' " + four_nodes + "/><DiagonalMass/>"));
  for (const char* part : {"/a has 5 nodes", "/b has 6 nodes", "/dofs has 4", "topology=\"@path\""})
    expectContains(text, part);
  const std::string linked =
      problemsOf(scene(mesh("a", four_nodes, tetrahedron) + mesh("b", six, triangles) + "<MechanicalObject name='dofs' " +
                     four_nodes + "/><DiagonalMass topology='@b'/>"));
  expectContains(linked, "/b has 6 nodes and /dofs has 4");
  EXPECT_EQ(linked.find("/a"), std::string::npos) << linked;
  expectContains(problemsOf(scene("<MechanicalObject name='dofs' " + four_nodes + "/><DiagonalMass/>")),
                 "there is no mesh");
}

/// A mapping has no way to know which of two topologies to cut: the error names both.
TEST(StateTopology, ACutOfOneOfTwoTopologiesNeedsALink) {
  const std::string grid = " n='2 2 2' min='0 0 0' max='1 1 1'/>";
  const std::string text = problemsOf(scene("<RegularGridTopology name='a'" + grid + "<RegularGridTopology name='b'" +
                                          grid + "<Node name='n'><Hexa2TetraTopologicalMapping/></Node>"));
  expectContains(text, "a and b");
  expectContains(text, "link");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
