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
#include "framework/mesh/cell_lists.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class SetTopologyContainer : public MeshContainer {
 public:
  void init() override {
    takeFromMapping();
    finish();
    if (countOfMainCells() == 0 && !allow_empty_)
      throw ComponentError(fmt::format("there are no {}", kind->plural),
                           fmt::format("{}=\"...\", or src=\"@loader\"", kind->plural));
    addParts();
  }

  std::string mainCells() const override { return std::string(kind->plural); }

  const CellKind* kind = &cell_kinds::edge;  ///< of the main cells
  void allowEmpty() { allow_empty_ = true; }

 private:
  std::size_t countOfMainCells() const;
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
