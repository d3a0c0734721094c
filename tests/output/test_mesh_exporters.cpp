// SPDX-License-Identifier: LGPL-2.1-or-later
// Meshes that are written, read again by the loaders: positions of the moment, cells, series and formats.
#include "tests/support/shell.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

class MeshExporters : public CommandTest {
 protected:
  /// A box that moves by 1 along x each second; two steps of a second.
  void run(const std::string& exporters) {
    write("scene.xml", R"(<Node name="root" dt="1" gravity="0 0 0"><EulerExplicitSolver/>
      <RegularGridTopology n="2 2 2" min="0 0 0" max="1 2 3"/>
      <MechanicalObject name="dofs" velocity="1 0 0  1 0 0  1 0 0  1 0 0  1 0 0  1 0 0  1 0 0  1 0 0"/>
      <UniformMass totalMass="1"/>)" + exporters + "</Node>");
    const Finished done = stroma("run scene.xml --no-record -n 2");
    ASSERT_EQ(done.code, 0) << done.err;
  }
  /// What a scene that loads the file knows of it.
  void expectMesh(const std::string& loader, const std::string& file, const std::string& container,
                  const std::string& expectations) {
    const std::string mesh = "<" + loader + " name=\"loader\" filename=\"" + file + "\"/><" + container + " src=\"@loader\"/>";
    write("check.xml", "<Node name=\"root\" gravity=\"0 0 0\"><EulerExplicitSolver/>" + mesh +
                           "<MechanicalObject name=\"dofs\"/><UniformMass totalMass=\"1\"/>" + expectations + "</Node>");
    const Finished done = stroma("run check.xml --no-record -n 1");
    EXPECT_EQ(done.code, 0) << file << "\n" << done.err;
  }
  void expectHas(const std::string& file, const std::string& part) const {
    const std::string text = readText(folder_ / file);
    EXPECT_NE(text.find(part), std::string::npos) << file << ":\n" << text;
  }
  bool exists(const std::string& file) const { return std::filesystem::exists(folder_ / file); }
};

const char* const at_two_seconds = R"(<Expect of="/dofs.volume" is="6"/>
  <Expect of="/dofs.position" axis="x" above="1.999" below="3.001"/>)";

TEST_F(MeshExporters, SurfacesAsObjAndStl) {
  run(R"(<OBJExporter filename="a" exportAtEnd="true"/><STLExporter filename="b" exportAtEnd="true"/>
         <STLExporter filename="c.stl" binaryformat="false" exportAtEnd="true"/>)");
  expectMesh("MeshOBJLoader", "a.obj", "TriangleSetTopologyContainer", at_two_seconds);
  expectMesh("MeshSTLLoader", "b.stl", "TriangleSetTopologyContainer", at_two_seconds);
  expectMesh("MeshSTLLoader", "c.stl", "TriangleSetTopologyContainer", at_two_seconds);
  EXPECT_EQ(readText(folder_ / "b.stl").size(), 84u + 12 * 50);
}

TEST_F(MeshExporters, SolidsForGmshAndVtk) {
  run(R"(<MeshExporter filename="a"/>)");
  expectMesh("MeshGmshLoader", "a.msh", "HexahedronSetTopologyContainer", at_two_seconds);
  expectMesh("MeshVTKLoader", "a.vtk", "HexahedronSetTopologyContainer", at_two_seconds);
  EXPECT_TRUE(exists("a.obj") && exists("a.mesh"));
  EXPECT_EQ(readText(folder_ / "a.mesh").substr(0, 2), "8\n");
}

TEST_F(MeshExporters, QuadraticCellsInTheOrderOfEachFormat) {
  write("scene.xml", R"(<Node name="root" dt="1" gravity="0 0 0"><EulerExplicitSolver/>
    <MeshTopology position="0 0 0  2 0 0  0 2 0  0 0 2  1 0 0  1 1 0  0 1 0  0 0 1  1 0 1  0 1 1"
                  quadraticTetrahedra="0 1 2 3 4 5 6 7 8 9"/>
    <MechanicalObject name="dofs"/><UniformMass totalMass="1"/><MeshExporter filename="q"/>
    <STLExporter filename="q" exportAtEnd="true"/></Node>)");
  const Finished done = stroma("run scene.xml --no-record -n 1");
  ASSERT_EQ(done.code, 0) << done.err;
  expectHas("q.vtk", "CELLS 1 11\n10 0 1 2 3 4 5 6 7 8 9\nCELL_TYPES 1\n24\n");
  expectHas("q.msh", "$Elements\n1\n1 11 0 1 2 3 4 5 6 7 8 10 9\n");
  expectHas("q.mesh", "\n1\n1 1 2 3 4\n4\n");
  EXPECT_EQ(readText(folder_ / "q.stl").size(), 84u + 16 * 50);  // four faces of four triangles
  expectMesh("MeshOBJLoader", "q.obj", "TriangleSetTopologyContainer", R"(<Expect of="/dofs.volume" is="1.3333333333333333"/>)");
}

TEST_F(MeshExporters, ASeriesIsNumbered) {
  run(R"(<OBJExporter filename="s" exportEveryNumberOfSteps="1" exportAtBegin="true"/><OBJExporter filename="off" enable="false"/>)");
  for (const char* file : {"s00000.obj", "s00001.obj", "s00002.obj"}) EXPECT_TRUE(exists(file)) << file;
  EXPECT_FALSE(exists("s00003.obj") || exists("off.obj"));
  expectMesh("MeshOBJLoader", "s00001.obj", "TriangleSetTopologyContainer",
             R"(<Expect of="/dofs.position" nodes="0" axis="x" is="1"/>)");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
