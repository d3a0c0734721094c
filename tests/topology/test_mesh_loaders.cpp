// SPDX-License-Identifier: LGPL-2.1-or-later
// The loaders of .msh and .obj files in scenes: lists, transform, groups, warnings and errors.
#include <cmath>

#include "tests/support/loader_fixture.h"

namespace stroma::test {
namespace {

const char* const two_tetrahedra =
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n2 5 \"skin\"\n3 1 \"body\"\n$EndPhysicalNames\n"
    "$Nodes\n5\n10 0 0 0\n20 1 0 0\n30 0 1 0\n40 0 0 1\n50 1 1 1\n$EndNodes\n"
    "$Elements\n4\n1 15 2 0 1 10\n2 2 2 5 1 20 30 40\n3 4 2 1 1 10 20 30 40\n4 4 2 1 1 20 30 40 50\n$EndElements\n";

using Loaders = LoaderTest;

TEST_F(Loaders, GmshIntoAContainer) {
  const std::string path = write("two.msh", two_tetrahedra);
  const Scene scene = sceneFromText(
      "<Node name=\"root\"><TetrahedronSetTopologyContainer name=\"t\" src=\"@loader\"/>"
      "<MeshGmshLoader name=\"loader\" filename=\"" +
      path + "\"/></Node>");
  const Mesh& held = dynamic_cast<Topology&>(*findComponent(*scene.root, "/t")).mesh();
  EXPECT_EQ(held.nodes(), 5);
  EXPECT_EQ(held.tetrahedra, (std::vector<Tetrahedron>{{0, 1, 2, 3}, {1, 2, 3, 4}}));
  EXPECT_EQ(held.triangles.size(), 7u);  // the one of the file, then the other faces
  EXPECT_EQ(held.triangles.front(), (Triangle{1, 2, 3}));
  EXPECT_EQ(held.edges.size(), 9u);
  expectContains(scene.diagnostics.text(), "1 point of the file is not used");
  EXPECT_EQ(mesh(sceneFromText(sceneText("MeshGmshLoader", path, "createSubelements=\"false\""))).triangles.size(), 1u);
}

TEST_F(Loaders, GmshDirections) {
  const std::string path =
      write("fibres.msh",
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 "
            "1\n$EndNodes\n$Elements\n2\n7 4 0 1 2 3 4\n3 4 0 2 3 4 5\n$EndElements\n$ElementData\n1\n"
            "\"fibres\"\n1\n0\n3\n0\n3\n2\n3 0 1 0.5\n7 1 0 0\n$EndElementData\n$NodeData\n1\n\"heat\"\n1\n"
            "0\n3\n0\n1\n1\n2 300\n$EndNodeData\n");
  const auto directions = [&](const std::string& more) {
    const Scene scene = sceneFromText(sceneText("MeshGmshLoader", path, "directionArray=\"fibres\"" + more));
    return *std::get<std::vector<Vec3>*>(
        findComponent(*scene.root, "/loader")->data().find("tetrahedraDirections")->pointer());
  };
  EXPECT_EQ(directions(""), (std::vector<Vec3>{{1, 0, 0}, {0, 1, 0.5}}));
  EXPECT_TRUE(directions(" rotation=\"0 0 90\"")[1].isApprox(Vec3(-1, 0, 0.5), 1e-14));
  expectContains(errors(sceneText("MeshGmshLoader", path, "directionArray=\"fibre\"")), "no view 'fibre'");
  expectContains(errors(sceneText("MeshGmshLoader", path, "directionArray=\"fibre\"")), "fibres");
  expectContains(errors(sceneText("MeshGmshLoader", path, "directionArray=\"heat\"")), "has 1 components");
}

TEST_F(Loaders, GmshValues) {
  const std::string path = write("young.msh", std::string(two_tetrahedra) +
                                                  "$ElementData\n1\n\"young\"\n1\n0\n3\n0\n1\n3\n4 25\n2 -7\n3 10\n$EndElementData\n");
  const auto text = [&](const std::string& more) { return sceneText("MeshGmshLoader", path, "valueArray=\"" + more); };
  const Scene scene = sceneFromText(text("young\" valueFactor=\"100\""));
  EXPECT_EQ(findComponent(*scene.root, "/loader")->data().find("tetrahedraValues")->print(), "1000 2500");
  expectContains(errors(text("yuong\"")), "no view 'yuong'");
  const std::string nodes = write("nodes.msh", std::string(two_tetrahedra) +
                                                   "$NodeData\n1\n\"heat\"\n1\n0\n3\n0\n1\n1\n10 3\n$EndNodeData\n");
  expectContains(errors(sceneText("MeshGmshLoader", nodes, "valueArray=\"heat\"")), "no values of volume elements");
}

TEST_F(Loaders, AFileOfVtkIsNamedAsOne) {
  const std::string path = write("mesh.msh", "# vtk DataFile Version 3.0\nmesh\nASCII\n");
  expectContains(errors(sceneText("MeshGmshLoader", path, "")), "this is a file of VTK");
}

TEST_F(Loaders, GmshGroups) {
  const std::string path = write("two.msh", two_tetrahedra);
  const auto indices = [&](const std::string& group) {
    const Scene scene = sceneFromText(sceneText("MeshGmshLoader", path, "group=\"" + group + "\""));
    return findComponent(*scene.root, "/loader")->data().find("groupIndices")->print();
  };
  EXPECT_EQ(indices("skin"), "1 2 3");
  EXPECT_EQ(indices("5"), "1 2 3");
  EXPECT_EQ(indices("body"), "0 1 2 3 4");
  const Scene skin = sceneFromText(sceneText("MeshGmshLoader", path, "group=\"skin\""));
  EXPECT_EQ(findComponent(*skin.root, "/loader")->data().find("groupTriangleIndices")->print(), "0");
  EXPECT_EQ(findComponent(*skin.root, "/loader")->data().find("groupQuadIndices")->print(), "");
  const std::string text = errors(sceneText("MeshGmshLoader", path, "group=\"skim\""));
  expectContains(text, "no physical group 'skim'");
  expectContains(text, "skin");
}

TEST_F(Loaders, TransformScalesThenTurnsThenMoves) {
  const std::string path = write("two.msh", two_tetrahedra);
  const Scene parts =
      sceneFromText(sceneText("MeshGmshLoader", path, R"(scale3d="2 3 4" rotation="0 0 90" translation="10 0 0")"));
  EXPECT_TRUE(mesh(parts).position[1].isApprox(Vec3(10, 2, 0), 1e-14));
  EXPECT_TRUE(mesh(parts).position[2].isApprox(Vec3(7, 0, 0), 1e-14));
  EXPECT_TRUE(mesh(parts).position[3].isApprox(Vec3(10, 0, 4), 1e-14));
  const Scene matrix =
      sceneFromText(sceneText("MeshGmshLoader", path, R"(transformation="0 -3 0 10  2 0 0 0  0 0 4 0  0 0 0 1")"));
  for (std::size_t n = 0; n < 5; ++n) EXPECT_TRUE(mesh(matrix).position[n].isApprox(mesh(parts).position[n], 1e-14));
  EXPECT_TRUE(
      mesh(sceneFromText(sceneText("MeshGmshLoader", path, "scale=\"2\""))).position[4].isApprox(Vec3(2, 2, 2)));
  expectContains(errors(sceneText("MeshGmshLoader", path, R"(scale="2" scale3d="1 1 2")")), "both scale and scale3d");
  expectContains(errors(sceneText("MeshGmshLoader", path, R"(scale3d="1 1 0" rotation="0 0 30")")),
                 "the mesh is flattened: its volume cells have none left");
  expectContains(errors(sceneText("MeshGmshLoader", path, R"(transformation="1 0 0 0  0 1 0 0  1 1 0 0  0 0 0 1")")),
                 "a transformation that can be undone");
  EXPECT_EQ(errors(sceneText("MeshGmshLoader", path, R"(scale3d="1e-9 1e-9 1")")), "") << "thin is not flat";
  expectContains(errors(sceneText("MeshGmshLoader", path, R"(transformation="1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 1")")),
                 "last row");
}

TEST_F(Loaders, AMirroredMeshHasNoInvertedCells) {
  const std::string path = write("two.msh", two_tetrahedra);
  const Scene scene = sceneFromText(sceneText("MeshGmshLoader", path, R"(scale3d="-1 1 1")"));
  expectContains(scene.diagnostics.text(), "the nodes of its 2 volume cells and of their faces are put in the order of the image");
  const Scene as_it_is = sceneFromText(sceneText("MeshGmshLoader", path, ""));
  ASSERT_FALSE(mesh(scene).triangles.empty());
  for (std::size_t i = 0; i < mesh(scene).triangles.size(); ++i) {
    const Triangle before = mesh(as_it_is).triangles[i];
    Triangle now = mesh(scene).triangles[i];
    std::rotate(now.begin(), std::find(now.begin(), now.end(), before[0]), now.end());
    EXPECT_EQ(now, (Triangle{before[0], before[2], before[1]})) << "else it would look into the body";
  }
  EXPECT_EQ(mesh(scene).tetrahedra, (std::vector<Tetrahedron>{{0, 2, 1, 3}, {1, 3, 2, 4}}));
  EXPECT_EQ(scene.diagnostics.text().find("inverted cells"), std::string::npos);
  const Scene turned = sceneFromText(sceneText("MeshGmshLoader", path, R"(scale3d="-1 -1 1")"));
  EXPECT_EQ(mesh(turned).tetrahedra.front(), (Tetrahedron{0, 1, 2, 3})) << "turned, not mirrored";
  const Scene grid = sceneFromText(sceneText(
      "MeshGmshLoader", write("cube.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n8\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n5 0 0 1\n"
                                          "6 1 0 1\n7 1 1 1\n8 0 1 1\n$EndNodes\n$Elements\n1\n1 5 0 1 2 3 4 5 6 7 8\n$EndElements\n"),
      R"(scale3d="1 -1 1")"));
  EXPECT_EQ(mesh(grid).hexahedra.front(), (Hexahedron{4, 5, 6, 7, 0, 1, 2, 3}));
}

TEST_F(Loaders, ReadPrismsAndPyramids) {
  const std::string text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n7\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 0 1\n6 0 1 1\n"
                           "7 2 2 0.5\n$EndNodes\n$Elements\n2\n1 6 2 3 0 1 2 3 4 5 6\n2 7 2 4 0 2 3 6 5 7\n$EndElements\n";
  const Scene scene = sceneFromText(sceneText("MeshGmshLoader", write("prism.msh", text)));
  EXPECT_EQ(scene.diagnostics.text(), "");
  EXPECT_EQ(mesh(scene).prisms, (std::vector<Prism>{{0, 1, 2, 3, 4, 5}}));
  EXPECT_EQ(mesh(scene).pyramids, (std::vector<Pyramid>{{1, 2, 5, 4, 6}}));
  EXPECT_EQ(mesh(scene).triangles.size(), 6u);
  EXPECT_EQ(mesh(scene).quads.size(), 3u) << "the one between them once";
  EXPECT_NEAR(mesh(scene).report().volume, 1.5, 1e-14);
  const Scene mirrored = sceneFromText(sceneText("MeshGmshLoader", write("prism.msh", text), R"(scale3d="1 -1 1")"));
  EXPECT_NEAR(mesh(mirrored).report().volume, 1.5, 1e-14);
  EXPECT_TRUE(mesh(mirrored).report().inverted.empty());
}

TEST_F(Loaders, WarnOfFaultsAndRefuseAnEmptyMesh) {
  std::string inverted = two_tetrahedra;
  inverted.replace(inverted.find("10 20 30 40\n"), 12, "20 10 30 40\n");
  expectContains(sceneFromText(sceneText("MeshGmshLoader", write("a.msh", inverted))).diagnostics.text(),
                 "1 inverted cells (0)");
  std::string unused = two_tetrahedra;
  unused.replace(unused.find("$Nodes\n5\n"), 9, "$Nodes\n6\n60 9 9 9\n");
  expectContains(sceneFromText(sceneText("MeshGmshLoader", write("b.msh", unused))).diagnostics.text(),
                 "1 unused nodes (0)");
  expectContains(errors(sceneText("MeshGmshLoader", write("c.msh", "$NOD\n0\n$ENDNOD\n$ELM\n0\n$ENDELM\n"))),
                 "has no nodes");
  expectContains(errors(sceneText("MeshGmshLoader", write("d.msh", "$NOD\n1\n1 0 0 0\n$ENDNOD\n$ELM\n0\n$ENDELM\n"))),
                 "has 1 nodes but no cell that can be used");
  expectContains(errors(sceneText("MeshGmshLoader", write("e.msh", "$NOD\n1\n1 nan 0 0\n$ENDNOD\n$ELM\n0\n$ENDELM\n"))),
                 "no cell");
  expectContains(errors(sceneText("MeshGmshLoader", "absent.msh")), "absent.msh");
}

TEST_F(Loaders, OnlyAttachedPointsLeavesOthersOut) {
  std::string unused = two_tetrahedra;
  unused.replace(unused.find("$Nodes\n5\n"), 9, "$Nodes\n6\n60 9 9 9\n");
  const Scene whole = sceneFromText(sceneText("MeshGmshLoader", write("a.msh", two_tetrahedra)));
  const Scene fewer = sceneFromText(
      sceneText("MeshGmshLoader", write("b.msh", unused), R"(onlyAttachedPoints="true" translation="1 2 3")"));
  ASSERT_EQ(mesh(fewer).nodes(), 5);
  EXPECT_EQ(fewer.diagnostics.text().find("unused"), std::string::npos);
  EXPECT_EQ(mesh(fewer).tetrahedra, mesh(whole).tetrahedra);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(mesh(fewer).position[i], mesh(whole).position[i] + Vec3(1, 2, 3)) << i;
}

TEST_F(Loaders, ObjKeepsTheNodesOfTheFile) {
  const std::string text =
      "# comment\nmtllib x.mtl\nv 0 0 0\nv 1 0 0\r\nv 1 1 0\nv 0 1 0\nv 0.5 2 0\nvn 0 0 1\nvt 0 0\ng a b\n"
      "f 1/1/1 2/1/1 3//1\nf 1 2 3 4\nf -5 -4 -3 -1 -2\nl 1 2 3\n";
  const Scene scene = sceneFromText(sceneText("MeshOBJLoader", write("a.obj", text)));
  const Mesh& m = mesh(scene);
  EXPECT_EQ(m.nodes(), 5);
  EXPECT_EQ(m.position[4], Vec3(0.5, 2, 0));
  EXPECT_EQ(m.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 1, 2}, {0, 2, 4}, {0, 4, 3}}));
  EXPECT_EQ(m.quads, (std::vector<Quad>{{0, 1, 2, 3}}));
  EXPECT_EQ(m.edges, (std::vector<Edge>{{0, 1}, {1, 2}}));
  expectContains(scene.diagnostics.text(), "1 polygons of more than four corners were cut");
  const Scene split =
      sceneFromText(sceneText("MeshOBJLoader", write("a.obj", text), R"(triangulate="1" flipNormals="1")"));
  EXPECT_TRUE(mesh(split).quads.empty());
  EXPECT_EQ(mesh(split).triangles.size(), 6u);
  EXPECT_EQ(mesh(split).triangles[0], (Triangle{0, 2, 1}));
}

TEST_F(Loaders, AFileMayHavePointsOnly) {
  const std::string file = write("p.obj", "v 1 2 3\nv 4 5 6\n");
  expectContains(errors(sceneText("MeshOBJLoader", file)), "has 2 nodes but no cell");
  const Scene scene = sceneFromText(sceneText("MeshOBJLoader", file, R"(pointsOnly="true" translation="0 0 1")"));
  ASSERT_EQ(mesh(scene).nodes(), 2);
  EXPECT_EQ(mesh(scene).position[1], Vec3(4, 5, 7));
}

TEST_F(Loaders, ObjErrorsHaveTheLine) {
  expectContains(errors(sceneText("MeshOBJLoader", write("a.obj", "v 0 0 0\nv 0 x 0\n"))),
                 "a.obj:2: 'x' is not a number");
  expectContains(errors(sceneText("MeshOBJLoader", write("b.obj", "v 0 0 0\nf 1 2 3\n"))),
                 "b.obj:2: node 2 is not one of the 1");
  expectContains(errors(sceneText("MeshOBJLoader", write("c.obj", "v 0 0 0\nf 1 0 1\n"))), "c.obj:2: node 0");
  expectContains(errors(sceneText("MeshOBJLoader", write("d.obj", "v 0 0 0\nf 1 1\n"))), "needs three nodes");
  expectContains(errors(sceneText("MeshOBJLoader", write("e.obj", "v 0 0\n"))), "e.obj:1");
}

TEST_F(Loaders, RealSurfaces) {
  const std::string folder = STROMA_SHARED_DATA "/meshes/";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is absent";
  EXPECT_EQ(mesh(sceneFromText(sceneText("MeshOBJLoader", folder + "liver-smooth.obj"))).nodes(), 2194);
  EXPECT_EQ(mesh(sceneFromText(sceneText("MeshOBJLoader", folder + "truthcylinder1.obj"))).nodes(), 830);
  const Scene bad = sceneFromText(sceneText("MeshGmshLoader", folder + "6_tetra_bad.msh"));
  expectContains(bad.diagnostics.text(), "inverted");
}

TEST_F(Loaders, CellsAndNodesThatAreThereTwiceAreSaid) {
  std::string text = two_tetrahedra;
  const auto replace = [&text](const std::string& old, const std::string& now) {
    text.replace(text.find(old), old.size(), now);
  };
  EXPECT_EQ(sceneFromText(sceneText("MeshGmshLoader", write("good.msh", text))).diagnostics.text().find("faults"),
            std::string::npos);
  replace("$Elements\n4\n", "$Elements\n5\n");
  replace("1 20 30 40 50\n$End", "1 20 30 40 50\n5 4 2 1 1 30 10 20 40\n$End");
  expectContains(sceneFromText(sceneText("MeshGmshLoader", write("cell.msh", text))).diagnostics.text(),
                 "1 volume cells that are there already (2)");
  text = two_tetrahedra;
  replace("$Nodes\n5\n", "$Nodes\n6\n");
  replace("50 1 1 1\n", "50 1 1 1\n60 1 0 1e-12\n");
  replace("1 20 30 40 50\n$End", "1 60 30 40 50\n$End");
  expectContains(sceneFromText(sceneText("MeshGmshLoader", write("node.msh", text))).diagnostics.text(),
                 "1 nodes in the place of others");
}

}  // namespace
}  // namespace stroma::test
