// SPDX-License-Identifier: LGPL-2.1-or-later
// Reads a mesh in VTK's formats: legacy .vtk (ASCII or binary, versions 1 to 5.1) and XML .vtu and .vtp.
//
// The format is detected from the content. Lines, triangles, quads, tetrahedra, hexahedra, wedges (prisms) and pyramids are
// read, pixels and voxels turned into quads and hexahedra, polylines into edges, strips and polygons into triangles (around
// their first corner). Quadratic triangles (6 nodes) and tetrahedra (10 nodes) are read too. Vertices and quadratic edges are
// counted and reported; other quadratic cells are an error. The faces and edges of the volume cells are added to the lists of
// the file unless createSubelements="false", as by MeshGmshLoader: a scene selects faces alike, whichever of the two has read
// its mesh. (In SOFA the default is false here.)
//
// Labels: when the file has cell data of whole numbers under the name `groupArray` (default "label"),
// `tetrahedraGroups` and its like hold the value of each cell, as MeshGmshLoader's hold the physical group.
//
// Directions: directionArray="fibres" names cell data or point data of three numbers, or six or nine for a frame of two
// or three vectors; `tetrahedraDirections`, `hexahedraDirections` and `nodeDirections` hold them, turned with the mesh,
// as AnisotropyDirections takes them.
//
// Values: valueArray="young" names cell data of one real number; `tetrahedraValues` and `hexahedraValues` hold them, times
// `valueFactor`: youngModulus="@loader.tetrahedraValues" is a Young's modulus from computed tomography.
//
// A separate program (read_vtk_mesh) reads the file; if a damaged file crashes it, an error is reported here.
//
// Source: VTK's readers (vtkGenericDataObjectReader, vtkXMLGenericDataObjectReader); the attributes are SOFA's.
//
// Example:
// <Node name="root">
//   <MeshVTKLoader name="loader" filename="meshes/block.vtk"/>
//   <TetrahedronSetTopologyContainer name="tets" src="@loader"/>
// </Node>
#include <fmt/format.h>

#include <cmath>

#include "components/topology/cell_values.h"
#include "components/topology/cells_from_vtk.h"
#include "framework/mesh/mesh_loader.h"
#include "framework/scene/factory.h"
#include "framework/scene/reader_process.h"

namespace stroma {
namespace {

const ReaderProgram program{"read_vtk_mesh", "VTK's reader", "`tools/setup build` in the sources installs VTK and builds it"};

class MeshVTKLoader : public MeshLoader {
 public:
  MeshVTKLoader() { create_subelements_ = true; }

  void declare(DataTable& table) override {
    MeshLoader::declare(table);
    table.add("groupArray", group_array_).help("cell data of whole numbers that go to tetrahedraGroups and its like");
    declareGroups(table, "label");
    declareDirections(table);
    values_.declare(table);
  }

 protected:
  void read(const std::string& file, Mesh& mesh) override {
    const std::string name = file.substr(file.rfind('/') + 1);
    VtkMesh content(readInOwnProcess(program, file, {group_array_, directions_.array, values_.array}), name);
    readDirections(content, name);
    readValues(content, name);
    for (const auto& [what, count] : content.addCells(labelsOf(content, name), mesh, groups_))
      if (const std::string cells = fmt::format("{} cell{} of kind {}", count, count == 1 ? "" : "s", what); leavesNoHole(what))
        inform(fmt::format("{} {} not used", cells, count == 1 ? "is" : "are"));
      else
        warn(cells + " without a counterpart here: the body has holes there", "tetrahedra, hexahedra, wedges and pyramids alone");
    mesh.position = std::move(content.position);
  }

 private:
  static bool leavesNoHole(std::string_view kind) {
    return kind == "vtkVertex" || kind == "vtkPolyVertex" || kind == "vtkQuadraticEdge" || kind == "vtkEmptyCell";
  }
  std::vector<int> labelsOf(const VtkMesh& content, const std::string& name) const;
  void readDirections(const VtkMesh& content, const std::string& name);
  void readValues(const VtkMesh& content, const std::string& name);

  CellValues values_;
  std::string group_array_ = "label";
};

/// The label of each cell; empty when the file has none and none was asked for.
std::vector<int> MeshVTKLoader::labelsOf(const VtkMesh& content, const std::string& name) const {
  const bool asked_for = data().find("groupArray")->isSet();
  if (!content.labels.found && asked_for)
    throw ComponentError(fmt::format("{} has no cell data '{}'", name, group_array_),
                         content.cell_arrays.empty() ? "a file with cell data" : "an array of the file",
                         nearest(group_array_, content.cell_arrays));
  bool whole = content.labels.width == 1;
  std::vector<int> labels;
  for (std::size_t c = 0; whole && c < content.labels.values.size(); ++c) {
    const double value = content.labels.values[c];
    whole = std::abs(value) <= 1e9 && value == std::floor(value);
    if (whole) labels.push_back(int(value));
  }
  if (whole) return labels;
  if (asked_for)
    throw ComponentError(
        fmt::format("{}: the cell data '{}' are no labels: {}", name, group_array_,
                    content.labels.width == 1 ? "real numbers" : fmt::format("{} components each", content.labels.width)),
        "one whole number per cell");
  return {};
}

/// The vectors of entry `at`, added.
void addVectors(const VtkArray& array, std::size_t at, std::vector<Vec3>& out) {
  const double* values = array.values.data() + at * array.width;
  for (std::size_t k = 0; k + 2 < array.width; k += 3) out.emplace_back(values[k], values[k + 1], values[k + 2]);
}

/// Directions of nodes and of those cells that become volume cells, one each, in the order of the file.
void MeshVTKLoader::readDirections(const VtkMesh& content, const std::string& name) {
  if (directions_.array.empty()) return;
  const VtkArray &of_cells = content.cell_directions, &of_points = content.point_directions;
  if (!of_cells.found && !of_points.found) {
    Texts names = content.cell_arrays;
    names.insert(names.end(), content.point_arrays.begin(), content.point_arrays.end());
    throw ComponentError(fmt::format("{} has neither cell nor point data '{}'", name, directions_.array),
                         names.empty() ? "a file with cell or point data" : "an array of the file",
                         nearest(directions_.array, names));
  }
  for (const VtkArray* array : {&of_cells, &of_points})
    if (array->found && array->width != 3 && array->width != 6 && array->width != 9)
      throw ComponentError(fmt::format("{}: the data '{}' have {} components", name, directions_.array, array->width),
                           "3 (a direction), 6 or 9 (two or three)");
  for (std::size_t n = 0; of_points.found && n < content.position.size(); ++n)
    addVectors(of_points, n, directions_.nodes);
  for (std::size_t c = 0; of_cells.found && c < content.cells(); ++c) {
    const CellKind* of_cell = content.kindOfCell(c);
    forEachCellList(
        [&](const CellKind& kind, std::vector<Vec3>& directions) {
          if (&kind == of_cell && kind.dimension == 3) addVectors(of_cells, c, directions);
        },
        directions_.cells);
  }
}

void MeshVTKLoader::readValues(const VtkMesh& content, const std::string& name) {
  if (values_.array.empty()) return;
  const VtkArray& array = content.cell_values;
  if (!array.found)
    throw ComponentError(fmt::format("{} has no cell data '{}'", name, values_.array),
                         content.cell_arrays.empty() ? "a file with cell data" : "an array of the file",
                         nearest(values_.array, content.cell_arrays));
  if (array.width != 1)
    throw ComponentError(fmt::format("{}: the cell data '{}' have {} components", name, values_.array, array.width),
                         "one number per cell");
  for (std::size_t c = 0; c < content.cells(); ++c) {
    const CellKind* of_cell = content.kindOfCell(c);
    forEachCellList(
        [&](const CellKind& kind, std::vector<double>& values) {
          if (&kind == of_cell && kind.dimension == 3) values_.add(values, array.values[c]);
        },
        values_.lists);
  }
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(mesh_vtk_loader) {
  factory.add<stroma::MeshVTKLoader>("MeshVTKLoader", "reads a mesh in VTK's formats (.vtk, .vtu, .vtp)");
}
