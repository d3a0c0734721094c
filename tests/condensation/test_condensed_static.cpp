// SPDX-License-Identifier: LGPL-2.1-or-later
// The condensed static solver against Newton's method with a sparse factorisation of the whole body.
#include "tests/condensation/bodies.h"

using namespace stroma;
using namespace stroma::test;

namespace {

const std::string newton =
    "<StaticSolver newton_iterations=\"5\" relative_residual_tolerance_threshold=\"1e-10\"/><SparseLDLSolver/>";

std::string twoMaterials(const std::string& cells) {
  const int count = cells == "tetrahedra" ? 4 * 3 * 6 * 6 : 4 * 3 * 6;
  std::string list;
  for (int i = 0; i < count; ++i) list += i < count / 3 ? "90000 " : "4000 ";
  return list;
}

double condensedAgainstNewton(Block block, const std::string& attributes) {
  block.solver = newton;
  const Vector expected = after(block.text(), 1);
  EXPECT_GT(norm(expected), 1e-4);
  block.solver = "<CondensedStaticSolver " + attributes + "/>";
  return difference(after(block.text(), 1), expected);
}

}  // namespace

TEST(CondensedStatic, isTheWholeBodyOnTheSurfaceAndInside) {
  for (const std::string cells : {"tetrahedra", "hexahedra"})
    for (const std::string attributes : {"", "condensed=\"false\""}) {
      Block block{.solver = "", .loads = "<ConstantForceField indices=\"139 138\" totalForce=\"0.05 0.02 -0.03\"/>"};
      block.cells = cells;
      EXPECT_LT(condensedAgainstNewton(block, attributes), 1e-10) << cells << attributes;
      block.young = twoMaterials(cells);
      EXPECT_LT(condensedAgainstNewton(block, attributes), 1e-10) << cells << attributes << ", two materials";
    }
}

TEST(CondensedStatic, countsTheNodesOfTheBoundary) {
  Simulation simulation = simulationFromText(Block{.solver = "<CondensedStaticSolver/>"}.text());
  const auto count = [&](const char* name) {
    return *std::get<int*>(simulation.systems().front()->integrator().data().find(name)->pointer());
  };
  EXPECT_EQ(count("interiorNodes"), 3 * 2 * 5);
  EXPECT_EQ(count("keptNodes"), 5 * 4 * 7 - 20 - 3 * 2 * 5);
}

TEST(CondensedStatic, loadsInsideReachTheSurface) {
  // node 2 + 5 (1 + 4 2) lies inside
  EXPECT_LT(condensedAgainstNewton(Block{.solver = "",
                                         .loads = "<ConstantForceField indices=\"47\" totalForce=\"0.1 0.02 0.2\"/>",
                                         .gravity = "0 0 0"},
                                   ""),
            1e-10);
}

TEST(CondensedStatic, keepsNamedNodes) {
  EXPECT_LT(condensedAgainstNewton(
                Block{.solver = "", .loads = "<ConstantForceField indices=\"139\" totalForce=\"0.05 0 0\"/>"},
                "surfaceIndices=\"139 47 60\""),
            1e-10);
}

TEST(CondensedStatic, nodesSlideInPlanes) {
  Block block{.solver = ""};
  block.more =
      "<FixedPlaneProjectiveConstraint direction=\"0 1 1\" indices=\"64 65 128\"/>"
      "<PartialFixedProjectiveConstraint indices=\"100 47\" fixedDirections=\"1 0 0\"/>";
  EXPECT_LT(condensedAgainstNewton(block, ""), 1e-10);
}

namespace {

/// A mesh of tetrahedra, held where it is lowest, pulled where it is highest.
std::string organScene(const std::string& file, const std::string& solver, double low, double high, int pulled) {
  return "<Node name=\"root\" dt=\"0.02\" gravity=\"0 -1 0\">" + solver +
         "<MeshGmshLoader name=\"loader\" filename=\"" + file +
         "\"/><TetrahedronSetTopologyContainer src=\"@loader\"/><MechanicalObject name=\"dofs\"/><DiagonalMass "
         "massDensity=\"1\"/><TetrahedronFEMForceField name=\"fem\" method=\"small\" youngModulus=\"5000\" "
         "poissonRatio=\"0.4\"/>"
         "<BoxROI name=\"low\" box=\"-99 " +
         std::to_string(low) + " -99 99 " + std::to_string(high) +
         " 99\" position=\"@dofs.rest_position\"/><FixedProjectiveConstraint "
         "indices=\"@low.indices\"/><ConstantForceField indices=\"" +
         std::to_string(pulled) + "\" totalForce=\"0.1 0.2 0.3\"/></Node>";
}

}  // namespace

TEST(CondensedStatic, liverAndOrganAreTheWholeBodies) {
  struct Mesh {
    std::string file;
    double low, high;
    int pulled;
  };
  const std::string here = std::string(STROMA_SOURCE_DIR) + "/scenes/meshes/",
                    shared = std::string(STROMA_SHARED_DATA) + "/meshes/";
  int compared = 0;
  for (const Mesh& mesh : {Mesh{here + "organ_5000.msh", 0.03, 99, 5}, Mesh{shared + "liver.msh", -99, 1, 60}}) {
    if (!std::filesystem::exists(mesh.file)) continue;
    const auto scene = [&](const std::string& solver) {
      return organScene(mesh.file, solver, mesh.low, mesh.high, mesh.pulled);
    };
    const Vector expected = after(scene(newton), 1);
    EXPECT_GT(norm(expected), 1e-6);
    EXPECT_LT(difference(after(scene("<CondensedStaticSolver/>"), 1), expected), 1e-10) << mesh.file;
    Simulation simulation = simulationFromText(scene("<CondensedStaticSolver/>"));
    EXPECT_GT(*std::get<int*>(simulation.systems().front()->integrator().data().find("interiorNodes")->pointer()), 10);
    ++compared;
  }
  EXPECT_GE(compared, 1);
}
