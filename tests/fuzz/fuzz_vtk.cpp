// SPDX-License-Identifier: LGPL-2.1-or-later
// What MeshVTKLoader takes from the program that runs VTK: any bytes, since a damaged file may make that program do
// anything. VTK itself is another's and its faults end that program; tests/fuzz/fuzz_scenes.py damages files that it reads.
#include "components/topology/cells_from_vtk.h"
#include "framework/mesh/mesh_loader.h"
#include "tests/fuzz/fuzz.h"

STROMA_FUZZ_TARGET(vtk) {
  using namespace stroma;
  try {
    const ValueLists lists = ValueLists::fromBytes({reinterpret_cast<const char*>(data), size});
    VtkMesh content(lists, "fuzz.vtk");
    Mesh mesh;
    PerCellList<std::vector<int>> groups;
    content.addCells(std::vector<int>(content.cells(), 1), mesh, groups);
    mesh.position = std::move(content.position);
    if (mesh.firstError().empty()) addSubelements(mesh);
    forEachCellList([](const CellKind&, const auto& cells,
                       const auto& labels) { fuzz::require(labels.size() <= cells.size(), "more labels than cells"); },
                    mesh, groups);
  } catch (const std::runtime_error&) {  // a sentence
  }
  return 0;
}
