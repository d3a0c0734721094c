// SPDX-License-Identifier: LGPL-2.1-or-later
// The condensed static solver against Newton's method with a sparse factorisation of the whole body.
#include "tests/condensation/bodies.h"

using namespace stroma;
using namespace stroma::test;

namespace {

const std::string whole_newton =
    "<StaticSolver newton_iterations=\"5\" relative_residual_tolerance_threshold=\"1e-10\"/><SparseLDLSolver/>";

std::string twoMaterials(const std::string& cells) {
  const int count = cells == "tetrahedra" ? 4 * 3 * 6 * 6 : 4 * 3 * 6;
  std::string list;
  for (int i = 0; i < count; ++i) list += i < count / 3 ? "90000 " : "4000 ";
  return list;
}

double condensedAgainstNewton(Block block, const std::string& attributes) {
  block.solver = whole_newton;
  const Vector expected = after(block.text(), 1);
  EXPECT_GT(norm(expected), 1e-4);
  block.solver = "<CondensedStaticSolver " + attributes + "/>";
  return difference(after(block.text(), 1), expected);
}

}  // namespace

TEST(CondensedStatic, IsTheWholeBodyOnTheSurfaceAndInside) {
  for (const std::string cells : {"tetrahedra", "hexahedra"})
    for (const std::string attributes : {"", "condensed=\"false\""}) {
      Block block{.solver = "", .loads = "<ConstantForceField indices=\"139 138\" totalForce=\"0.05 0.02 -0.03\"/>"};
      block.cells = cells;
      EXPECT_LT(condensedAgainstNewton(block, attributes), 1e-10) << cells << attributes;
      block.young = twoMaterials(cells);
      EXPECT_LT(condensedAgainstNewton(block, attributes), 1e-10) << cells << attributes << ", two materials";
    }
}

TEST(CondensedStatic, CountsTheNodesOfTheBoundary) {
  Simulation simulation = simulationFromText(Block{.solver = "<CondensedStaticSolver/>"}.text());
  const auto count = [&](const char* name) {
    return *std::get<int*>(simulation.systems().front()->integrator().data().find(name)->pointer());
  };
  EXPECT_EQ(count("interiorNodes"), 3 * 2 * 5);
  EXPECT_EQ(count("keptNodes"), 5 * 4 * 7 - 20 - 3 * 2 * 5);
}

TEST(CondensedStatic, LoadsInsideReachTheSurface) {
  // node 2 + 5 (1 + 4 2) lies inside
  EXPECT_LT(condensedAgainstNewton(Block{.solver = "",
                                         .loads = "<ConstantForceField indices=\"47\" totalForce=\"0.1 0.02 0.2\"/>",
                                         .gravity = "0 0 0"},
                                   ""),
            1e-10);
}

TEST(CondensedStatic, KeepsNamedNodes) {
  EXPECT_LT(condensedAgainstNewton(
                Block{.solver = "", .loads = "<ConstantForceField indices=\"139\" totalForce=\"0.05 0 0\"/>"},
                "surfaceIndices=\"139 47 60\""),
            1e-10);
}

TEST(CondensedStatic, NodesSlideInPlanes) {
  Block block{.solver = ""};
  block.more =
      "<FixedPlaneProjectiveConstraint direction=\"0 1 1\" indices=\"64 65 128\"/>"
      "<PartialFixedProjectiveConstraint indices=\"100 47\" fixedDirections=\"1 0 0\"/>";
  EXPECT_LT(condensedAgainstNewton(block, ""), 1e-10);
}
