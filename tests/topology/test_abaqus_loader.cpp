// SPDX-License-Identifier: LGPL-2.1-or-later
// MeshAbaqusLoader: elements, sets, surfaces and regions of .inp files, and what is refused.
#include <fmt/format.h>

#include <Eigen/Geometry>

#include "framework/mesh/topology.h"
#include "tests/support/loader_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// Two hexahedra, one on the other, whose nodes and elements have large numbers; a keyword and an element go over two lines.
const char* const column =
    "*HEADING\nline, of text\n** a comment\n*Node, nset=\"All\"\n 101, 0., 0., 0.\n 102, 1., 0.\n 103, 1., 1., 0.\n 104, 0., +1.\n"
    "105, 0, 0, 1\n106, 1, 0, 1\n107, 1, 1, 1\n108, 0, 1, 1\n109, 0, 0, 2e0\n110, 1, 0, 2\n111, 1, 1, 2\n112, 0, 1, 2\n"
    "*Element, type=C3D8R,\n elset=soft\n 7, 101, 102, 103, 104, 105,\n 106, 107, 108\n"
    "*ELEMENT, TYPE=C3D8, ELSET=STIFF\n9, 105, 106, 107, 108, 109, 110, 111, 112\n"
    "*NSET, NSET=Bottom, GENERATE\n101, 103, 1\n*NSET, NSET=BOTTOM\n104\n*NSET, NSET=BOTH\nbottom, 112\n"
    "*ELSET, ELSET=ALL\nSOFT, STIFF\n*SURFACE, NAME=TOP\nSTIFF, S2\n*SURFACE, NAME=SIDES, TYPE=ELEMENT\nALL, S3\n9, S6\n"
    "*SOLID SECTION, ELSET=STIFF, MATERIAL=A\n*SOLID SECTION, ELSET=SOFT, MATERIAL=B\n1.\n*MATERIAL, NAME=A\n*ELASTIC\n1000., 0.3\n";

class Abaqus : public LoaderTest {
 protected:
  Scene load(const std::string& text, const std::string& more = "") {
    return sceneFromText(sceneText("MeshAbaqusLoader", write("file.inp", text), more));
  }
  std::string output(const std::string& text, const std::string& more, const char* name) {
    const Scene scene = load(text, more);
    return findComponent(*scene.root, "/loader")->data().find(name)->print();
  }
  std::string errorOf(const std::string& text, const std::string& more = "") {
    return errors(sceneText("MeshAbaqusLoader", write("file.inp", text), more));
  }
};

TEST_F(Abaqus, NodesAndCellsAreThoseOfTheFile) {
  const Scene scene = load(column, "createSubelements=\"false\"");
  const Mesh& held = mesh(scene);
  ASSERT_EQ(held.nodes(), 12);
  EXPECT_EQ(held.position[11], Vec3(0, 1, 2));
  EXPECT_EQ(held.position[1], Vec3(1, 0, 0));
  EXPECT_EQ(held.hexahedra, (std::vector<Hexahedron>{{0, 1, 2, 3, 4, 5, 6, 7}, {4, 5, 6, 7, 8, 9, 10, 11}}));
  EXPECT_TRUE(held.quads.empty());
}

TEST_F(Abaqus, RegionsAreSetsThatHaveASectionOrThatAreNamed) {
  EXPECT_EQ(output(column, "", "hexahedraGroups"), "2 1");
  expectContains(load(column).diagnostics.text(), "1 STIFF, 2 SOFT");
  EXPECT_EQ(output(column, "regions=\"soft stiff\"", "hexahedraGroups"), "1 2");
  EXPECT_EQ(output(column, "regions=\"stiff\"", "hexahedraGroups"), "0 1");
  const std::string bare(column, std::string(column).find("*SOLID"));
  EXPECT_EQ(output(bare, "", "hexahedraGroups"), "1 2") << "lines *ELEMENT name them";
  expectContains(errorOf(column, "regions=\"sofd\""), "did you mean 'SOFT'");
}

TEST_F(Abaqus, SetsAndSurfacesAreSelections) {
  EXPECT_EQ(output(column, "group=\"BOTTOM\"", "groupIndices"), "0 1 2 3");
  EXPECT_EQ(output(column, "group=\"both\"", "groupIndices"), "0 1 2 3 11");
  EXPECT_EQ(output(column, "group=\"stiff\"", "groupIndices"), "4 5 6 7 8 9 10 11");
  EXPECT_EQ(output(column, "group=\"top\"", "groupIndices"), "8 9 10 11");
  EXPECT_EQ(output(column, "group=\"top\"", "groupQuadIndices"), "0");
  EXPECT_EQ(output(column, "group=\"sides\"", "groupQuadIndices"), "0 1 2");
  EXPECT_EQ(output(column, "group=\"sides\"", "quadsGroups").substr(0, 5), "0 0 0");
  EXPECT_EQ(mesh(load(column, "group=\"sides\"")).quads.size(), 11u) << "no face of the two cells is there twice";
  expectContains(errorOf(column, "group=\"topp\""), "did you mean 'TOP'");
}

TEST_F(Abaqus, WhatIsNamedTwiceIsThereOnce) {
  std::string twice(column);
  twice.replace(twice.find("ALL, S3"), 7, "ALL, S3\n9, S3\n9, S6");
  EXPECT_EQ(output(twice, "group=\"sides\"", "groupQuadIndices"), "0 1 2");
  EXPECT_EQ(mesh(load(twice, "group=\"sides\"")).quads.size(), 11u);
  std::string itself(column);
  itself.replace(itself.find("bottom, 112"), 11, "bottom, 112\nboth, both");
  EXPECT_EQ(output(itself, "group=\"both\"", "groupIndices"), "0 1 2 3 11");
}

TEST_F(Abaqus, AFileBeginsWithItsByteOrderAndSetsHaveNumbersThatAreNotThere) {
  const std::string text(column);
  EXPECT_EQ(mesh(load("\xEF\xBB\xBF*NODE\n" + text.substr(text.find(" 101,")))).nodes(), 12);
  std::string lost(column);
  lost.replace(lost.find("bottom, 112"), 11, "bottom, 112, 113");
  expectContains(load(lost, "group=\"both\"").diagnostics.text(), "names 1 nodes that are not in the file");
}

TEST_F(Abaqus, ParametersThatChangeTheMeshAreRefused) {
  const std::pair<const char*, const char*> changes[] = {{"*Node, nset=\"All\"", "*Node, system=C"},
                                                         {"*ELEMENT, TYPE=C3D8,", "*ELEMENT, INPUT=a, TYPE=C3D8,"},
                                                         {"*NSET, NSET=BOTH", "*NSET, NSET=BOTH, ELSET=SOFT"},
                                                         {"NAME=TOP", "NAME=TOP, COMBINE=UNION"}};
  for (const auto& [from, to] : changes) {
    std::string text(column);
    text.replace(text.find(from), std::string(from).size(), to);
    expectContains(errorOf(text), "is not read");
  }
}

/// As Abaqus/CAE names them.
TEST_F(Abaqus, ASetOfTheAssemblyHidesThatOfThePart) {
  const std::string text =
      "*PART, NAME=P\n*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n*ELEMENT, TYPE=C3D4\n1,1,2,3,4\n*NSET, NSET=SET-1\n1,2,3,4\n"
      "*ELSET, ELSET=SET-1\n1\n"
      "*SOLID SECTION, ELSET=SET-1, MATERIAL=M\n*END PART\n*ASSEMBLY, NAME=A\n*INSTANCE, NAME=I, PART=P\n*END INSTANCE\n"
      "*NSET, NSET=SET-1, INSTANCE=I\n1,2\n*END ASSEMBLY\n";
  EXPECT_EQ(output(text, "group=\"Set-1\"", "groupIndices"), "0 1");
  EXPECT_EQ(output(text, "group=\"I.Set-1\"", "groupIndices"), "0 1 2 3");
  EXPECT_EQ(output(text, "regions=\"I.Set-1\"", "tetrahedraGroups"), "1");
}

TEST_F(Abaqus, ASurfaceOfNodesIsOfSetsAndNumbersOfNodes) {
  const std::string text =
      "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n*ELEMENT, TYPE=C3D4, ELSET=A\n1,1,2,3,4\n*NSET, NSET=A\n3\n"
      "*SURFACE, NAME=S, TYPE=NODE\n1, 1.0\n4\nA, 0.5\n";
  EXPECT_EQ(output(text, "group=\"S\"", "groupIndices"), "0 2 3");
}

/// Each face of a cell looks out of it, and its middles lie between its corners.
TEST_F(Abaqus, FacesLookOutOfTheirCells) {
  const std::string nodes =
      "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n5,.5,0,0\n6,.5,.5,0\n7,0,.5,0\n8,0,0,.5\n9,.5,0,.5\n10,0,.5,.5\n11,1,1,0\n12,1,0,1\n"
      "13,1,1,1\n14,0,1,1\n";
  const std::pair<const char*, int> kinds[] = {
      {"*ELEMENT, TYPE=C3D4\n1,1,2,3,4\n", 4}, {"*ELEMENT, TYPE=C3D10M\n1,1,2,3,4,5,6,7,8,9,10\n", 4},
      {"*ELEMENT, TYPE=C3D8I\n1,1,2,11,3,4,12,13,14\n", 6}};
  for (const auto& [elements, faces] : kinds)
    for (int face = 1; face <= faces; ++face) {
      SCOPED_TRACE(elements + std::to_string(face));
      const std::string text = nodes + elements + "*SURFACE, NAME=S\n1, S" + std::to_string(face) + "\n";
      const Scene scene = load(text, "group=\"s\" onlyAttachedPoints=\"false\" createSubelements=\"false\"");
      const Mesh& held = mesh(scene);
      std::vector<Vec3> corners, middles;
      for (const Triangle& t : held.triangles) for (const Index n : t) corners.push_back(held.position[std::size_t(n)]);
      for (const Quad& q : held.quads) for (const Index n : q) corners.push_back(held.position[std::size_t(n)]);
      for (const QuadraticTriangle& t : held.quadratic_triangles)
        for (std::size_t k = 0; k < 6; ++k) (k < 3 ? corners : middles).push_back(held.position[std::size_t(t[k])]);
      ASSERT_GE(corners.size(), 3u);
      const Vec3 inside = faces == 6 ? Vec3(.5, .5, .5) : Vec3(.2, .2, .2);
      EXPECT_GT((corners[1] - corners[0]).cross(corners[2] - corners[0]).dot(corners[0] - inside), 0);
      for (std::size_t k = 0; k < middles.size(); ++k) EXPECT_EQ(middles[k], 0.5 * (corners[k] + corners[(k + 1) % 3]));
    }
}

/// As Abaqus/CAE writes it: a part, its instance, and a reference point of the assembly with a number of the part.
TEST_F(Abaqus, APartAndItsInstance) {
  const std::string text =
      "*Part, name=P\n*Node\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n*Element, type=C3D4\n1,1,2,3,4\n*End Part\n*Assembly, name=A\n"
      "*Instance, name=P-1, part=P\n{}*End Instance\n*Node\n1, 9, 9, 9\n*Nset, nset=ref\n1\n*Nset, nset=held, instance=P-1\n2, 3\n"
      "*Elset, elset=_S2, internal, instance=P-1\n1\n*Surface, type=ELEMENT, name=s\n_S2, S2\n*End Assembly\n";
  const auto with = [&](const std::string& line) { return fmt::format(fmt::runtime(text), line); };
  EXPECT_EQ(mesh(load(with(""))).nodes(), 4);
  EXPECT_EQ(output(with(""), "group=\"held\"", "groupIndices"), "1 2");
  EXPECT_EQ(output(with(""), "group=\"s\"", "groupIndices"), "0 1 3");
  EXPECT_EQ(load(with("0., 0., 0.\n")).diagnostics.text().find("moves"), std::string::npos);
  expectContains(load(with("5., 0., 0.\n")).diagnostics.text(), "moves the instance P-1");
  expectContains(errorOf(with("*End Instance\n*Instance, name=P-2, part=P\n")), "second instance");
}

TEST_F(Abaqus, WhatIsLeftOutIsToldAndWhatIsWrongIsRefused) {
  const std::string nodes = "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n5,1,0,1\n6,0,1,1\n", cell = "*ELEMENT, TYPE=C3D4\n1,1,2,3,4\n";
  expectContains(load(nodes + cell + "*ELEMENT, TYPE=C3D7\n2,1,2,3,4,5,6\n").diagnostics.text(), "1 element C3D7");
  expectContains(load(nodes + cell + "*ELEMENT, TYPE=MASS\n2,1\n3,2\n").diagnostics.text(), "2 elements MASS of the file are not used");
  const std::pair<std::string, const char*> wrong[] = {
      {nodes + "*ELEMENT, TYPE=C3D20\n", "file.inp:8: elements C3D20 are not supported"},
      {nodes + "*ELEMENT, TYPE=C3D4\n1,1,2,3,40\n", "file.inp:9: element 1 names node 40"},
      {nodes + "*ELEMENT, TYPE=C3D4\n1,1,2,3\n*STEP\n", "element 1 has 3 nodes"},
      {nodes + "*ELEMENT, TYPE=C3D4\n1,1,2,3,4,5\n", "element 1 has 5 nodes"},
      {nodes + "*ELEMENT, TYPE=C3D4\n1,1,2,3\n", "element 1 has 3 nodes"},
      {nodes + cell + cell, "element 1 is there twice"},
      {nodes + "*ELEMENT\n1,1,2,3,4\n", "*ELEMENT has no TYPE"},
      {"*NODE\n1,0,zero,0\n", "file.inp:2: 'zero' is no number"},
      {"*NODE\n1,0,0,0\n1,0,0,0\n", "node 1 is there twice"},
      {"*INCLUDE, INPUT=other.inp\n", "*INCLUDE is not read"},
      {nodes + "*NSET, NSET=A\nB\n", "there is no set B"},
      {nodes + "*NSET, NSET=A, GENERATE\n1, 9000000000000000000\n", "at most 20 million"},
      {nodes + "*NSET, NSET=A, GENERATE\n-9000000000000000000, 9000000000000000000\n", "at most 20 million"},
      {"$MeshFormat\n", "has no *NODE"},
  };
  for (const auto& [text, message] : wrong) expectContains(errorOf(text), message);
  expectContains(errorOf(nodes + cell + "*SURFACE, NAME=S\n1, S5\n", "group=\"s\""), "S1 to S4");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
