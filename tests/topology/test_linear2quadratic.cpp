// SPDX-License-Identifier: LGPL-2.1-or-later
// Raising the order of a mesh inside a scene.
#include "framework/mesh/cell_kind.h"
#include "framework/mesh/topology.h"
#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

const std::string grid = "<RegularGridTopology name=\"grid\" n=\"3 3 3\" min=\"0 0 0\" max=\"1 1 1\"/>";
const std::string cut = "<Hexa2TetraTopologicalMapping name=\"tets\" input=\"@../grid\"/>";

Simulation raisedScene(const std::string& more = "", const std::string& before = cut) {
  return simulationFromText("<Node name=\"root\" gravity=\"0 0 0\">" + grid +
                            "<Node name=\"body\"><EulerImplicitSolver/>" + "<SparseLDLSolver/>" + before +
                            "<Linear2QuadraticTopologicalMapping name=\"mesh\" input=\"@tets\"/>"
                            "<MechanicalObject name=\"dofs\" src=\"@mesh\"/><DiagonalMass massDensity=\"1\"/>" +
                            more + "</Node></Node>");
}
const Mesh& meshOf(const Simulation& simulation, const std::string& path) {
  return dynamic_cast<Topology&>(*findComponent(simulation.root(), path)).mesh();
}

TEST(Linear2Quadratic, CornersKeepTheirNumbersAndEdgesGetOneNodeEach) {
  const Simulation simulation = raisedScene();
  const Mesh &linear = meshOf(simulation, "/body/tets"), &mesh = meshOf(simulation, "/body/mesh");
  ASSERT_EQ(mesh.quadratic_tetrahedra.size(), linear.tetrahedra.size());
  EXPECT_EQ(mesh.nodes(), linear.nodes() + Index(linear.allEdges().size()));
  EXPECT_EQ(mesh.nodes(), 125);  // the cut into six has every node of a grid twice as fine
  for (std::size_t c = 0; c < mesh.quadratic_tetrahedra.size(); ++c) {
    const QuadraticTetrahedron& cell = mesh.quadratic_tetrahedra[c];
    for (std::size_t a = 0; a < 4; ++a) EXPECT_EQ(cell[a], linear.tetrahedra[c][a]);
    for (std::size_t e = 0; e < 6; ++e) {
      const auto [a, b] = cell_tables::tetrahedron_middles[e];
      const auto& p = mesh.position;
      EXPECT_EQ(p[cell[4 + e]], (p[cell[std::size_t(a)]] + p[cell[std::size_t(b)]]) / 2);
    }
  }
  EXPECT_EQ(mesh.firstError(), "");
  EXPECT_NEAR(mesh.report().volume, 1, 1e-14);
  EXPECT_NEAR(mesh.report().worst_quality, linear.report().worst_quality, 1e-12);
  EXPECT_EQ(mesh.boundaryQuadraticTriangles().size(), linear.boundaryTriangles().size());
}

TEST(Linear2Quadratic, SelectionsAndListsOfTheLinearMeshGoWithIt) {
  const Simulation simulation = raisedScene(
      "<BoxROI name=\"floor\" box=\"-1 -1 -0.001 2 2 0.001\"/><FixedProjectiveConstraint indices=\"@floor.indices\"/>"
      "<QuadraticTetrahedronFEMForceField youngModulus=\"1000\" poissonRatio=\"0.3\"/>");
  EXPECT_EQ(findComponent(simulation.root(), "/body/floor")->data().find("nbIndices")->print(), "25");
  const Simulation listed = simulationFromText(
      "<Node name=\"root\"><MeshTopology name=\"tets\" position=\"0 0 0 1 0 0 0 1 0 0 0 1\" tetrahedra=\"0 1 2 3\" "
      "triangles=\"0 2 1\"/><Linear2QuadraticTopologicalMapping name=\"mesh\" indices=\"0 1 2\"/>"
      "<MechanicalObject src=\"@mesh\"/><UniformMass totalMass=\"1\"/><EulerExplicitSolver/></Node>");
  EXPECT_EQ(findComponent(listed.root(), "/mesh")->data().find("raisedIndices")->print(), "0 1 2 4 5 7");
  EXPECT_EQ(meshOf(listed, "/mesh").quadratic_triangles.size(), 1u);
}

TEST(Linear2Quadratic, RefusesWhatItWouldLose) {
  const auto problems = [](const std::string& body) {
    return problemsOf("<Node name=\"root\">" + grid + "<Node name=\"body\">" + body + "</Node></Node>");
  };
  EXPECT_NE(problems("<Linear2QuadraticTopologicalMapping/>").find("neither tetrahedra nor triangles"),
            std::string::npos);
  EXPECT_NE(problems("<Linear2QuadraticTopologicalMapping/>").find("Hexa2TetraTopologicalMapping"), std::string::npos);
  EXPECT_NE(
      problems(cut + "<Linear2QuadraticTopologicalMapping input=\"@tets\" indices=\"99\"/>").find("indices[0] is 99"),
      std::string::npos);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
