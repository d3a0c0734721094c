// SPDX-License-Identifier: LGPL-2.1-or-later
// The containers of SOFA's topologies (PointSet-, EdgeSet-, TriangleSet-, QuadSet-, TetrahedronSet- and
// HexahedronSetTopologyContainer): a mesh whose main cells are of one kind.
//
// The cells come from attributes, from a loader (src="@loader") or from a topological mapping that names the container as
// its output (one that makes tetrahedra may also lie beside it). Edges and faces of the main cells are derived when something
// asks for them; createTriangleArray and createQuadArray make them a part of the mesh at once.
//
// Source: the attributes are those of SOFA.
//
// Example:
// <Node name="root">
//   <TetrahedronSetTopologyContainer name="tets" position="0 0 0  1 0 0  0 1 0  0 0 1" tetrahedra="0 1 2 3"
//                                    createTriangleArray="true"/>
// </Node>
#include <fmt/format.h>

#include "components/topology/mesh_container.h"
#include "framework/mesh/cell_faces.h"
#include "framework/mesh/cell_lists.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class SetTopologyContainer : public MeshContainer {
 public:
  void declare(DataTable& table) override {
    MeshContainer::declare(table);
    table.add("createTriangleArray", create_triangles_)
        .help("add the faces of the tetrahedra when no triangle is given");
    table.add("createQuadArray", create_quads_).help("add the faces of the hexahedra when no quad is given");
    table.add("createEdgeArray", create_edges_).help("add the edges of all cells when no edge is given");
  }

  void init() override {
    takeFromMapping();
    finish();
    if (countOfMainCells() == 0 && !allow_empty_)
      throw ComponentError(fmt::format("there are no {}", kind->plural),
                           fmt::format("{}=\"...\", or src=\"@loader\"", kind->plural));
    if (create_triangles_ && mesh_.triangles.empty()) mesh_.triangles = uniqueTriangles(mesh_, false);
    if (create_quads_ && mesh_.quads.empty()) mesh_.quads = uniqueQuads(mesh_, false);
    if (create_edges_ && mesh_.edges.empty()) mesh_.edges = Mesh(mesh_).allEdges();
  }

  std::string mainCells() const override { return std::string(kind->plural); }

  const CellKind* kind = &cell_kinds::edge;  ///< of the main cells
  void allowEmpty() { allow_empty_ = true; }

 private:
  std::size_t countOfMainCells() const;

  bool create_triangles_ = false, create_quads_ = false, create_edges_ = false;
};

std::size_t SetTopologyContainer::countOfMainCells() const {
  std::size_t count = 0;
  forEachCellList([&](const CellKind& each, const auto& cells) { count += &each == kind ? cells.size() : 0; }, mesh_);
  return count;
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(set_topology_containers) {
  namespace kinds = stroma::cell_kinds;
  const auto add = [&factory](const char* type, const stroma::CellKind& kind) {
    factory.add<stroma::SetTopologyContainer>(
        type, fmt::format("a mesh of {}", kind.plural),
        [&kind](stroma::SetTopologyContainer& made) { made.kind = &kind; });
  };
  factory.add<stroma::SetTopologyContainer>("PointSetTopologyContainer", "points without cells",
                                            [](stroma::SetTopologyContainer& made) { made.allowEmpty(); });
  add("EdgeSetTopologyContainer", kinds::edge);
  add("TriangleSetTopologyContainer", kinds::triangle);
  add("QuadSetTopologyContainer", kinds::quad);
  add("TetrahedronSetTopologyContainer", kinds::tetrahedron);
  add("HexahedronSetTopologyContainer", kinds::hexahedron);
}
