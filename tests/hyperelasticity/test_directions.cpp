// SPDX-License-Identifier: LGPL-2.1-or-later
// AnisotropyDirections from another component and of nodes: the same forces as directions written cell by cell; what is
// refused, and that the sentence names the cell.
#include <fmt/format.h>

#include "tests/hyperelasticity/law_cases.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

const std::string hexahedral = "HexahedronHyperelasticityFEMForceField";
const std::string fibres = "materialName=\"TransverselyIsotropic\" ParameterSet=\"1000 4000 3000 1.5\" ";
const std::string frames = "materialName=\"Costa\" ParameterSet=\"500 5000 8 4 2 4 2 3\" ";

std::string directions(const std::string& values) { return "AnisotropyDirections=\"" + values + "\""; }

/// Two tetrahedra on five nodes, or a row of two cubes on twelve.
std::string body(bool cubes, const std::string& attributes, const std::string& more = "") {
  const std::string mesh =
      cubes
          ? "<MeshTopology name=\"mesh\" position=\"0 0 0 1 0 0 2 0 0 0 1 0 1 1 0 2 1 0 0 0 1 1 0 1 2 0 1 0 1 1 1 1 1 "
            "2 1 1\" hexahedra=\"0 1 4 3 6 7 10 9  1 2 5 4 7 8 11 10\"/>"
          : "<MeshTopology name=\"mesh\" position=\"0 0 0 1 0 0 0 1 0 0 0 1 1 1 1\" tetrahedra=\"0 1 2 3 1 2 3 4\"/>";
  return "<Node name=\"root\" dt=\"0.01\"><EulerImplicitSolver/><CGLinearSolver/>" + mesh +
         "<MechanicalObject/><UniformMass totalMass=\"1\"/>" + more + "<" + (cubes ? hexahedral : tetrahedral) + " " +
         attributes + "/></Node>";
}
Vector forces(bool cubes, const std::string& attributes, const std::string& more = "") {
  FieldUnderTest t(body(cubes, attributes, more), cubes ? hexahedral : tetrahedral);
  t.deform(0.1);
  return t.force();
}
std::string repeated(const std::vector<std::string>& values) {
  std::string text;
  for (const std::string& v : values) text += v + "  ";
  return text;
}

TEST(AnisotropyDirections, OfATableByLabels) {
  const std::string table = "<ValuesFromLabels name=\"fibres\" labels=\"7 4\" width=\"3\" table=\"4 0 1 1  7 1 2 0\"/>";
  const std::string pairs =
      "<ValuesFromLabels name=\"frames\" labels=\"7 4\" width=\"6\" table=\"4 0 1 1 1 0 0  7 1 2 0 0 0 1\"/>";
  for (const bool cubes : {false, true}) {
    const Vector linked = forces(cubes, fibres + directions("@fibres.values"), table);
    EXPECT_EQ(relativeDifference(linked, forces(cubes, fibres + directions("1 2 0  0 1 1"))), 0);
    EXPECT_GT(relativeDifference(linked, forces(cubes, fibres + directions("0 1 1  1 2 0"))), 1e-3) << "nothing tested";
    EXPECT_EQ(relativeDifference(forces(cubes, frames + directions("@frames.values"), pairs),
                                 forces(cubes, frames + directions("1 2 0 0 0 1  0 1 1 1 0 0"))),
              0);
  }
}

TEST(AnisotropyDirections, OfNodesAreAveragedWhateverTheirSigns) {
  for (const bool cubes : {false, true}) {
    std::vector<std::string> same(cubes ? 12 : 5, "1 2 1"), pairs(same.size(), "1 2 0 0 0 2");
    same[1] = "-2 -4 -2", same[3] = "-1 -2 -1", pairs[2] = "-1 -2 0 0 0 1", pairs[4] = "3 6 0 0 0 -1";
    EXPECT_LT(relativeDifference(forces(cubes, fibres + directions(repeated(same))),
                                 forces(cubes, fibres + directions("1 2 1"))),
              1e-13);
    EXPECT_LT(relativeDifference(forces(cubes, frames + directions(repeated(pairs))),
                                 forces(cubes, frames + directions("1 2 0 0 0 1"))),
              1e-13);
  }
  // corners that lean to both sides of x by the same angles; the second cell also has the fifth node
  const std::string leaning = directions("1 0.3 0  -1 0.3 0  1 0 0.2  1 0 -0.2  1 0 0");
  const Vector of_nodes = forces(false, fibres + leaning), along = forces(false, fibres + directions("1 0 0"));
  EXPECT_LT((Vec3(of_nodes[0]) - Vec3(along[0])).norm(), 1e-12 * Vec3(along[0]).norm()) << "of the first cell alone";
  EXPECT_GT(relativeDifference(of_nodes, along), 1e-4) << "the second leans";
}

TEST(AnisotropyDirections, WhatIsNoneIsRefusedWithItsCell) {
  const auto expectRefused = [](const std::string& attributes, const std::vector<std::string>& words) {
    const std::string problems = problemsOf(body(false, attributes));
    for (const std::string& word : words) EXPECT_NE(problems.find(word), std::string::npos) << word << ": " << problems;
  };
  expectRefused(
      fibres + directions("1 0 0  0 1 0  0 0 1"),
      {"AnisotropyDirections of TransverselyIsotropic has 3 vectors", "1, 2 (one per cell) or 5 (one per node)"});
  expectRefused(frames + directions("1 0 0"), {"has 1 vectors", "4 or 6 (for each cell)", "10 or 15 (for each node)"});
  expectRefused(fibres + directions("1 0 0  0 0 0"),
                {"the fibre of tetrahedron 1 (nodes 1 2 3 4) is 0 0 0", "a vector with a length"});
  expectRefused(fibres + directions("0 0 0"), {"the fibre of all cells is 0 0 0"});
  expectRefused(fibres + directions("1 0 0  1 0 0  1 0 0  0 0 0  1 0 0"), {"the fibre of node 3 is 0 0 0"});
  expectRefused(frames + directions("1 0 0  0 1 0  0 1 0  0 0 0"), {"the sheet of tetrahedron 1 (nodes 1 2 3 4) is 0"});
  expectRefused(frames + directions("1 0 0  0 1 0  0 1 0  0 -3 0"),
                {"fibre and sheet of tetrahedron 1 (nodes 1 2 3 4) are parallel (0 1 0)"});
  expectRefused(fibres + directions("1 0 0  1 0 0  0 1 0  0 1 0  1 0 0"),
                {"the fibres at the corners of tetrahedron 0 (nodes 0 1 2 3) have no mean", "they cross"});
}

/// As many cells as nodes: those of the cells, and a word of it.
TEST(AnisotropyDirections, ACountOfBothIsSaid) {
  const std::string scene =
      "<Node name=\"root\" dt=\"0.01\"><EulerImplicitSolver/><CGLinearSolver/>"
      "<MeshTopology name=\"mesh\" position=\"0 0 0 1 0 0 0 1 0 0 0 1 0 -1 0 -1 0 0\" "
      "tetrahedra=\"0 1 2 3  0 2 5 3  0 5 4 3  0 4 1 3  0 2 1 3  0 1 4 3\"/><MechanicalObject/>"
      "<UniformMass totalMass=\"1\"/><" +
      tetrahedral + " " + fibres + directions("1 0 0  0 1 0  0 0 1  1 0 0  0 1 0  0 0 1") + "/></Node>";
  const Scene loaded = sceneFromText(scene);
  EXPECT_NE(loaded.diagnostics.text().find("fit the 6 cells and the 6 nodes"), std::string::npos)
      << loaded.diagnostics.text();
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
