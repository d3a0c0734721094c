// SPDX-License-Identifier: LGPL-2.1-or-later
// MeshVTKLoader and MeshSTLLoader on files that VTK's own writers made, in every version and encoding, and on wrong
// ones.
#include <fmt/format.h>
#include <vtkCellType.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataWriter.h>
#include <vtkSTLWriter.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>
#include <vtkUnstructuredGridWriter.h>
#include <vtkXMLPolyDataWriter.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include "framework/mesh/cell_lists.h"
#include "tests/vtk_io/vtk_fixture.h"

namespace stroma::test {
namespace {

template <class T>
using Pointer = vtkSmartPointer<T>;

/// One cell of every kind that is read, on the corners of a unit cube and a point above it.
Pointer<vtkUnstructuredGrid> allKinds() {
  const auto points = Pointer<vtkPoints>::New();
  points->SetDataTypeToDouble();
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j < 2; ++j)
      for (int i = 0; i < 2; ++i) points->InsertNextPoint(i, j, k);
  points->InsertNextPoint(1.0 / 3, 0.5, 2);
  auto grid = Pointer<vtkUnstructuredGrid>::New();
  grid->SetPoints(points);
  const auto add = [&grid](int type, std::vector<vtkIdType> nodes) {
    grid->InsertNextCell(type, vtkIdType(nodes.size()), nodes.data());
  };
  add(VTK_LINE, {0, 8});
  add(VTK_POLY_LINE, {1, 2, 3});
  add(VTK_TRIANGLE, {0, 1, 8});
  add(VTK_TRIANGLE_STRIP, {0, 1, 2, 3});
  add(VTK_POLYGON, {0, 1, 3, 8, 2});
  add(VTK_QUAD, {0, 1, 3, 2});
  add(VTK_PIXEL, {4, 5, 6, 7});
  add(VTK_TETRA, {4, 5, 6, 8});
  add(VTK_HEXAHEDRON, {0, 1, 3, 2, 4, 5, 7, 6});
  add(VTK_VOXEL, {0, 1, 2, 3, 4, 5, 6, 7});
  add(VTK_WEDGE, {0, 1, 2, 4, 5, 6});
  add(VTK_PYRAMID, {4, 5, 7, 6, 8});
  add(VTK_VERTEX, {5});
  return grid;
}

const std::string as_written = "createSubelements=\"false\"";

void expectAllKinds(const Mesh& mesh) {
  ASSERT_EQ(mesh.nodes(), 9);
  EXPECT_EQ(mesh.position[8], Vec3(1.0 / 3, 0.5, 2));
  EXPECT_EQ(mesh.edges, (std::vector<Edge>{{0, 8}, {1, 2}, {2, 3}}));
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 8}, {0, 1, 2}, {2, 1, 3}, {0, 1, 3}, {0, 3, 8}, {0, 8, 2}}));
  EXPECT_EQ(mesh.quads, (std::vector<Quad>{{0, 1, 3, 2}, {4, 5, 7, 6}}));
  EXPECT_EQ(mesh.tetrahedra, (std::vector<Tetrahedron>{{4, 5, 6, 8}}));
  EXPECT_EQ(mesh.hexahedra, (std::vector<Hexahedron>{{0, 1, 3, 2, 4, 5, 7, 6}, {0, 1, 3, 2, 4, 5, 7, 6}}));
  EXPECT_EQ(mesh.prisms, (std::vector<Prism>{{0, 1, 2, 4, 5, 6}}));
  EXPECT_EQ(mesh.pyramids, (std::vector<Pyramid>{{4, 5, 7, 6, 8}}));
  EXPECT_NEAR(cell_kinds::prism.size(cornersOf(mesh.prisms[0], mesh.position).data()), 1. / 2, 1e-15);
  EXPECT_NEAR(cell_kinds::pyramid.size(cornersOf(mesh.pyramids[0], mesh.position).data()), 1. / 3, 1e-15);
}

/// Two tetrahedra and a triangle with cell data "fibres" and point data "frames" of two vectors.
const std::string with_directions = R"(# vtk DataFile Version 3.0
two cells
ASCII
DATASET UNSTRUCTURED_GRID
POINTS 5 double
0 0 0 1 0 0 0 1 0 0 0 1 1 1 1
CELLS 3 14
4 0 1 2 3
3 0 1 2
4 1 2 3 4
CELL_TYPES 3
10 5 10
CELL_DATA 3
SCALARS label int 1
LOOKUP_TABLE default
1 1 1
VECTORS fibres double
1 0 0
9 9 9
0 1 0.5
POINT_DATA 5
FIELD more 2
frames 6 5 double
1 0 0 0 1 0  1 0 0 0 1 0  1 0 0 0 1 0  1 0 0 0 1 0  1 0 0 0 1 0
heat 1 5 double
1 2 3 4 5
)";

TEST_F(VtkTest, DirectionsOfCellsAndNodes) {
  const std::string path = write("fibres.vtk", with_directions);
  const auto listOf = [&](const std::string& attributes, const std::string& name) {
    const Scene scene = sceneFromText(sceneText("MeshVTKLoader", path, attributes));
    return *std::get<std::vector<Vec3>*>(findComponent(*scene.root, "/loader")->data().find(name)->pointer());
  };
  EXPECT_EQ(listOf("directionArray=\"fibres\"", "tetrahedraDirections"), (std::vector<Vec3>{{1, 0, 0}, {0, 1, 0.5}}));
  EXPECT_TRUE(listOf("directionArray=\"fibres\"", "nodeDirections").empty());
  EXPECT_TRUE(listOf("", "tetrahedraDirections").empty());
  const std::vector<Vec3> frames = listOf("directionArray=\"frames\"", "nodeDirections");
  ASSERT_EQ(frames.size(), 10u);
  EXPECT_EQ(frames[9], Vec3(0, 1, 0));
  // a quarter turn about z, twice as long along the mesh's x before it
  const std::vector<Vec3> turned =
      listOf("directionArray=\"fibres\" rotation=\"0 0 90\" scale3d=\"2 1 1\"", "tetrahedraDirections");
  EXPECT_TRUE(turned[0].isApprox(Vec3(0, 2, 0), 1e-14));
  EXPECT_TRUE(turned[1].isApprox(Vec3(-1, 0, 0.5), 1e-14));

  expectContains(errors(sceneText("MeshVTKLoader", path, "directionArray=\"fibers\"")),
                 "neither cell nor point data 'fibers'");
  expectContains(errors(sceneText("MeshVTKLoader", path, "directionArray=\"fibers\"")), "fibres");
  expectContains(errors(sceneText("MeshVTKLoader", path, "directionArray=\"heat\"")),
                 "the data 'heat' have 1 components");
}

/// The second array of scalars of a legacy file, of the volume cells, in the order of the file.
TEST_F(VtkTest, ValuesOfCellsReachAMaterial) {
  std::string text = with_directions;
  text.replace(text.find("VECTORS"), 0, "SCALARS young double 1\nLOOKUP_TABLE default\n0.001 -7 0.0025\n");
  const std::string path = write("young.vtk", text);
  const auto scene = [&](const std::string& attributes) {
    return "<Node name=\"root\" dt=\"0.01\"><EulerImplicitSolver/><CGLinearSolver/><MeshVTKLoader name=\"loader\" filename=\"" + path +
           "\" " + attributes +
           "/><TetrahedronSetTopologyContainer src=\"@loader\"/><MechanicalObject/><UniformMass totalMass=\"1\"/>"
           "<TetrahedronFEMForceField name=\"fem\" youngModulus=\"@loader.tetrahedraValues\" poissonRatio=\"0.3\"/></Node>";
  };
  const Scene loaded = sceneFromText(scene("valueArray=\"young\" valueFactor=\"1e6\""));
  EXPECT_EQ(findComponent(*loaded.root, "/fem")->data().find("youngModulus")->print(), "1000 2500");
  expectContains(errors(scene("valueArray=\"yuong\"")), "no cell data 'yuong'");
  expectContains(errors(scene("valueArray=\"yuong\"")), "did you mean 'young'");
  expectContains(errors(scene("valueArray=\"fibres\"")), "the cell data 'fibres' have 3 components");
  expectContains(errors(scene("groupArray=\"young\"")), "the cell data 'young' are no labels: real numbers");
}

/// From the file into a law, of cells and of nodes.
TEST_F(VtkTest, DirectionsReachALaw) {
  const std::string path = write("fibres.vtk", with_directions);
  const auto problems = [&](const std::string& array, const std::string& law) {
    return errors(
        "<Node name=\"root\" dt=\"0.01\"><EulerImplicitSolver/><CGLinearSolver/><MeshVTKLoader name=\"loader\" "
        "filename=\"" +
        path + "\" directionArray=\"" + array +
        "\"/>"
        "<TetrahedronSetTopologyContainer src=\"@loader\"/><MechanicalObject/><UniformMass totalMass=\"1\"/>"
        "<TetrahedronHyperelasticityFEMForceField " +
        law + "/></Node>");
  };
  const std::string fibres = "materialName=\"TransverselyIsotropic\" ParameterSet=\"1000 4000 3000 1.5\" ";
  const std::string frames = "materialName=\"Costa\" ParameterSet=\"500 5000 8 4 2 4 2 3\" ";
  EXPECT_EQ(problems("fibres", fibres + "AnisotropyDirections=\"@loader.tetrahedraDirections\""), "");
  EXPECT_EQ(problems("frames", frames + "AnisotropyDirections=\"@loader.nodeDirections\""), "");
  expectContains(problems("frames", fibres + "AnisotropyDirections=\"@loader.nodeDirections\""), "has 10 vectors");
}

/// As MeshGmshLoader does: a scene selects faces alike, whichever of the two has read its mesh.
TEST_F(VtkTest, FacesAndEdgesOfCellsAreListed) {
  const std::string path = write("cells.vtk", with_directions);
  const Mesh all = load("MeshVTKLoader", path), own = load("MeshVTKLoader", path, as_written);
  EXPECT_EQ(own.triangles.size(), 1u);
  EXPECT_EQ(own.edges.size(), 0u);
  EXPECT_EQ(all.triangles.size(), 7u);  // the one of the file, then the other faces of two tetrahedra
  EXPECT_EQ(all.triangles.front(), own.triangles.front());
  EXPECT_EQ(all.edges.size(), 9u);
}

TEST_F(VtkTest, LegacyVersionsAndEncodings) {
  for (const int version : {42, 51})
    for (const bool binary : {false, true}) {
      SCOPED_TRACE(testing::Message() << version << (binary ? " binary" : " ASCII"));
      const auto writer = Pointer<vtkUnstructuredGridWriter>::New();
      const std::string path = folder_ / "mesh.vtk";
      writer->SetFileName(path.c_str());
      writer->SetInputData(allKinds());
      writer->SetFileVersion(version);
      binary ? writer->SetFileTypeToBinary() : writer->SetFileTypeToASCII();
      writer->Write();
      const Mesh mesh = load("MeshVTKLoader", path, as_written);
      if (binary) {
        expectAllKinds(mesh);
      } else {
        EXPECT_EQ(mesh.hexahedra.size(), 2u);  // ASCII holds fewer digits
        EXPECT_TRUE(mesh.position[8].isApprox(Vec3(1.0 / 3, 0.5, 2), 1e-6));
      }
    }
}

TEST_F(VtkTest, XmlEncodings) {
  for (const int mode : {0, 1, 2}) {
    const auto writer = Pointer<vtkXMLUnstructuredGridWriter>::New();
    const std::string path = folder_ / "mesh.vtu";
    writer->SetFileName(path.c_str());
    writer->SetInputData(allKinds());
    writer->SetDataMode(mode);
    writer->Write();
    expectAllKinds(load("MeshVTKLoader", path, as_written));
  }
  const Scene scene = sceneFromText(sceneText("MeshVTKLoader", folder_ / "mesh.vtu"));
  expectContains(scene.diagnostics.text(), "1 cell of kind vtkVertex is not used");
}

/// The corners of a square without cells, the first one at (x, y).
Pointer<vtkPolyData> square(double first_x, double first_y) {
  const auto points = Pointer<vtkPoints>::New();
  for (const auto& [x, y] : {std::pair(first_x, first_y), {1, 0}, {1, 1}, {0, 1}}) points->InsertNextPoint(x, y, 0.5);
  auto data = Pointer<vtkPolyData>::New();
  data->SetPoints(points);
  data->Allocate(2);
  return data;
}

TEST_F(VtkTest, PolyData) {
  const auto data = square(0, 0);
  const vtkIdType triangle[] = {0, 1, 2}, quad[] = {0, 1, 2, 3};
  data->InsertNextCell(VTK_TRIANGLE, 3, triangle);
  data->InsertNextCell(VTK_QUAD, 4, quad);
  const auto writer = Pointer<vtkXMLPolyDataWriter>::New();
  writer->SetFileName((folder_ / "a.vtp").c_str());
  writer->SetInputData(data);
  writer->Write();
  const auto legacy = Pointer<vtkPolyDataWriter>::New();
  legacy->SetFileName((folder_ / "a.vtk").c_str());
  legacy->SetInputData(data);
  legacy->Write();
  for (const char* name : {"a.vtp", "a.vtk"}) {
    const Mesh mesh = load("MeshVTKLoader", folder_ / name);
    EXPECT_EQ(mesh.triangles.size(), 1u) << name;
    EXPECT_EQ(mesh.quads, (std::vector<Quad>{{0, 1, 2, 3}})) << name;
  }
}

TEST_F(VtkTest, StlSharesItsNodes) {
  const auto data = square(0.1, 0.2);
  const vtkIdType first[] = {0, 1, 2}, second[] = {0, 2, 3};
  data->InsertNextCell(VTK_TRIANGLE, 3, first);
  data->InsertNextCell(VTK_TRIANGLE, 3, second);
  for (const bool binary : {false, true}) {
    const auto writer = Pointer<vtkSTLWriter>::New();
    const std::string path = folder_ / "a.stl";
    writer->SetFileName(path.c_str());
    writer->SetInputData(data);
    binary ? writer->SetFileTypeToBinary() : writer->SetFileTypeToASCII();
    writer->Write();
    const Mesh mesh = load("MeshSTLLoader", path);
    EXPECT_EQ(mesh.nodes(), 4);
    EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}));
    EXPECT_TRUE(mesh.position[0].isApprox(Vec3(0.1, 0.2, 0.5), 1e-6));
  }
}

TEST_F(VtkTest, WrongFilesAreSentencesAndPrintNothing) {
  const auto with = [this](const std::string& type, const std::string& name, const std::string& content) {
    testing::internal::CaptureStderr();
    testing::internal::CaptureStdout();
    const std::string text = errors(sceneText(type, write(name, content)));
    EXPECT_EQ(testing::internal::GetCapturedStderr() + testing::internal::GetCapturedStdout(), "") << name;
    EXPECT_NE(text, "") << name;
    return text;
  };
  expectContains(with("MeshVTKLoader", "a.vtk", "hello"), "a.vtk is not a file of VTK");
  with("MeshVTKLoader", "b.vtk",
       "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 9 float\n0 0");
  with("MeshVTKLoader", "c.vtu", "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece Numb");
  with("MeshVTKLoader", "d.vtk", "# vtk DataFile Version 3.0\nx\nASCII\nDATASET NONSENSE\n");
  expectContains(
      with(
          "MeshVTKLoader", "m.vtk",
          "# vtk DataFile Version 3.0\nx 999999999\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 999999999 float\n0 0 0\n"),
      "m.vtk:5: POINTS 999999999 are declared");
  expectContains(with("MeshVTKLoader", "n.vtu",
                      "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece NumberOfPoints=\"999999999999\" "
                      "NumberOfCells=\"1\"></Piece></UnstructuredGrid></VTKFile>"),
                 "NumberOfPoints=\"999999999999\" is declared");
  expectContains(
      with("MeshVTKLoader", "o.vtk",
           "# vtk DataFile Version 3.0\nx\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 3 3 3\nORIGIN 0 0 0\n"
           "SPACING 1 1 1\n"),
      "holds no mesh");
  with("MeshVTKLoader", "e.vtk",
       "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n0 0 0 1 0 0 0 1 0 0 0 1\n"
       "CELLS 1 5\n4 0 1 2 9\nCELL_TYPES 1\n10\n");
  expectContains(
      with("MeshVTKLoader", "f.vtk",
           "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 8 float\n0 0 0 2 0 0 2 2 0\n"
           "0 2 0 1 0 0 2 1 0 1 2 0 0 1 0\nCELLS 1 9\n8 0 1 2 3 4 5 6 7\nCELL_TYPES 1\n23\n"),
      "vtkQuadraticQuad are not supported");
  expectContains(
      with("MeshVTKLoader", "p.vtk",
           "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 3 float\n0 0 0 1 0 0 2 0 0\n"
           "CELLS 1 4\n3 0 1 2\nCELL_TYPES 1\n10\n"),
      "p.vtk: a tetrahedron with 3 nodes");
  expectContains(with("MeshSTLLoader", "g.stl", ""), "cannot be read as STL");
  expectContains(with("MeshSTLLoader", "h.stl", "nonsense"), "cannot be read as STL");
  expectContains(with("MeshSTLLoader", "i.stl", "solid\nfacet\nvertex 0 0 0\nvertex 0 x 0\n"),
                 "i.stl:4: 'x' is not a number");
  expectContains(with("MeshSTLLoader", "j.stl", "solid\nvertex 0 0 0\nendfacet\nendsolid\n"),
                 "j.stl:3: a facet has 1 corners");
  expectContains(with("MeshSTLLoader", "k.stl", "solid\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendfacet\n"),
                 "is cut short");
  expectContains(with("MeshSTLLoader", "l.stl", std::string(84, 'x')), "cannot be read as STL");
}

/// `declared`: how many numbers the cells have together, by the file.
std::string chainOfTetrahedra(int declared) {
  std::string text = "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 20 double\n";
  for (int n = 0; n < 20; ++n) text += fmt::format("{} {} {}\n", n % 3, n % 5, n);
  text += fmt::format("CELLS 12 {}\n", declared);
  for (int c = 0; c < 12; ++c) text += fmt::format("4 {} {} {} {}\n", c, c + 1, c + 2, c + 3);
  text += "CELL_TYPES 12\n";
  for (int c = 0; c < 12; ++c) text += "10\n";
  return text;
}

/// VTK makes room for what the file declares, and writes beyond it.
TEST_F(VtkTest, AFileOnWhichVtkCrashesIsASentence) {
  EXPECT_EQ(load("MeshVTKLoader", write("good.vtk", chainOfTetrahedra(60))).tetrahedra.size(), 12u);
  const std::string path = write("bad.vtk", chainOfTetrahedra(30));
  for (int again = 0; again < 2; ++again)
    expectContains(errors(sceneText("MeshVTKLoader", path)), "bad.vtk: VTK's reader ");  // and how it ended
}

TEST_F(VtkTest, RealFiles) {
  const std::string folder = STROMA_SHARED_DATA "/meshes/";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is absent";
  const Mesh raptor = load("MeshVTKLoader", folder + "raptorTetra_8418.vtu");
  EXPECT_EQ(raptor.nodes(), 2996);
  EXPECT_EQ(raptor.tetrahedra.size(), 8418u);
  const Mesh liver = load("MeshVTKLoader", folder + "liver.vtk");
  EXPECT_EQ(liver.nodes(), 5008);
  EXPECT_EQ(liver.triangles.size(), 10000u);
}

}  // namespace
}  // namespace stroma::test
