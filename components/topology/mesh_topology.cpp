// SPDX-License-Identifier: LGPL-2.1-or-later
// A mesh given in the scene, taken from a loader (src="@loader") or read directly from a Gmsh file (filename).
//
// Cells keep their order. Edges and faces of volume cells are computed on demand. createEdgeArray, createTriangleArray and createQuadArray
// make them a part of the mesh. Without positions, those of the state in the same node are used.
//
// Source: the attributes are those of SOFA's MeshTopology.
//
// Example:
// <Node name="root">
//   <MeshTopology name="mesh" position="0 0 0  1 0 0  0 1 0  0 0 1" tetrahedra="0 1 2 3"/>
// </Node>
#include <fmt/format.h>

#include "components/topology/gmsh_reader.h"
#include "components/topology/mesh_container.h"
#include "framework/mesh/cell_lists.h"
#include "framework/mesh/mesh_loader.h"
#include "framework/scene/factory.h"
#include "framework/scene/written_units.h"

namespace stroma {
namespace {

class MeshTopology : public MeshContainer {
 public:
  void declare(DataTable& table) override {
    table.add("filename", filename_).alias("fileTopology").help("Gmsh file to read the mesh from").input();
    table.add("unit", unit_).help("unit of the file's positions, as mm: they become metres; empty: metres");
    MeshContainer::declare(table);
  }
  void init() override {
    takeFromMapping();
    if (!filename_.empty()) readFile();
    if (filename_.empty() && !unit_.empty())
      throw ComponentError("unit is that of a file, and there is none", "position with a unit, as \"0 0 0 10 0 0 mm\"");
    finish();
    addParts();
    if (!filename_.empty()) complainOfCells();
  }

 private:
  void readFile() {
    const auto refuse = [this](std::string_view name) {
      if (data().find(name)->isSet())
        throw ComponentError(fmt::format("both filename and {} are given", name), "one of them");
    };
    refuse("position");
    forEachCellList([&refuse](const CellKind& kind, const auto&) { refuse(kind.plural); }, mesh_);
    if (!filename_.given.ends_with(".msh"))
      throw ComponentError(fmt::format("filename {} is not a Gmsh file", filename_.given), "a .msh file",
                           "a loader of the format, and src=\"@loader\"");
    mesh_ = readGmsh(filename_.found).mesh;
    makeMetres(mesh_.position, unit_);
  }

  FileName filename_;
  std::string unit_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(mesh_topology) {
  factory.add<stroma::MeshTopology>("MeshTopology",
                                    "a mesh given by lists of nodes and cells, or read from a .msh file");
}
