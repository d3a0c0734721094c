// SPDX-License-Identifier: LGPL-2.1-or-later
// The containers of SOFA's topologies (EdgeSet-, TriangleSet-, QuadSet-, TetrahedronSet- and
// HexahedronSetTopologyContainer): a mesh whose main cells are of one kind.
//
// The cells come from attributes, from a loader (src="@loader") or, for tetrahedra, from a topological mapping that
// names the container as its output or lies beside it. Edges and faces of the main cells are derived when something
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
    if (kind == &cell_kinds::tetrahedron) takeFromMapping();
    finish();
    if (mainCells() == 0)
      throw ComponentError(fmt::format("there are no {}", kind->plural),
                           fmt::format("{}=\"...\", or src=\"@loader\"", kind->plural));
    if (create_triangles_ && mesh_.triangles.empty()) mesh_.triangles = uniqueFaces(mesh_.tetrahedra, false);
    if (create_quads_ && mesh_.quads.empty()) mesh_.quads = uniqueFaces(mesh_.hexahedra, false);
    if (create_edges_ && mesh_.edges.empty()) mesh_.edges = Mesh(mesh_).allEdges();
  }

  const CellKind* kind = &cell_kinds::edge;  ///< of the main cells

 private:
  void takeFromMapping();
  std::size_t mainCells() const;

  bool create_triangles_ = false, create_quads_ = false, create_edges_ = false;
};

void SetTopologyContainer::takeFromMapping() {
  std::vector<TopologicalMapping*> mappings;
  node().root().collect(mappings);
  TopologicalMapping* mine = nullptr;
  for (TopologicalMapping* mapping : mappings) {
    if (mapping->output() != this) continue;
    if (mine) throw ComponentError(fmt::format("both {} and {} fill this container", mine->path(), mapping->path()));
    mine = mapping;
  }
  if (!mine) return;
  const auto refuse = [&](std::string_view name) {
    throw ComponentError(fmt::format("{} are given, and {} fills this container too", name, mine->path()),
                         "one of them");
  };
  // what a linked loader has is replaced; what stands here would be lost without a word
  const auto is_written = [this](std::string_view name) {
    const DataOrigin origin = data().find(name)->origin();
    return origin == DataOrigin::written || origin == DataOrigin::by_override;
  };
  if (!mesh_.tetrahedra.empty()) refuse("tetrahedra");
  if (!mesh_.position.empty() && is_written("position")) refuse("positions");
  forEachCellList(
      [&](const CellKind& each, const auto& cells) {
        if (!cells.empty() && is_written(each.plural)) refuse(each.plural);
      },
      mesh_);
  mine->ensureReady();
  // Hexahedra that came with the positions would count the body a second time.
  mesh_ = mine->mesh();
}

std::size_t SetTopologyContainer::mainCells() const {
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
  add("EdgeSetTopologyContainer", kinds::edge);
  add("TriangleSetTopologyContainer", kinds::triangle);
  add("QuadSetTopologyContainer", kinds::quad);
  add("TetrahedronSetTopologyContainer", kinds::tetrahedron);
  add("HexahedronSetTopologyContainer", kinds::hexahedron);
}
