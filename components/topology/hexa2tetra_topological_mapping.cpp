// SPDX-License-Identifier: LGPL-2.1-or-later
// Cuts each hexahedron of a mesh into tetrahedra on the same nodes.
//
// cutting:
// - six (default): around the diagonal from corner 0 to corner 6, as SOFA does. In a grid the faces of neighbours match.
//   With swapping="true" each cell is the mirror image of its neighbours, so that no diagonal is preferred.
// - five1, five2: the two ways to cut a hexahedron into five. A corner's index is the binary number zyx:
//     1: (1 4 5 7) (0 1 4 2) (1 3 2 7) (2 4 6 7) (1 2 4 7)     2: (5 0 1 3) (4 5 0 6) (5 7 6 3) (6 0 2 3) (5 6 0 3)
//   All cells are cut alike, so the faces of neighbours do not match. A warning tells how many.
// - five: five1 or five2, chosen for each cell so that all faces match.
// - ten: both superposed, symmetric in every cell. The cells cover the body twice. Elastic force fields and masses on this topology
//   count each cell half (stiffnessScale 0.5), so youngModulus and density keep their values.
// - mirrored: six with swapping, but mirrored corner by corner, so that the tetrahedra of every other cell have a negative volume. SOFA's
//   TetrahedronFEMForceField cuts a grid in this way. It matters because the frame of its method large depends on the order of the nodes.
//
// The tetrahedra go to the container named by `output`, or to a TetrahedronSetTopologyContainer beside the mapping. Without one, the
// mapping itself is the topology of its node. With a cut into n, hexahedron h becomes tetrahedra n h to n h + n - 1.
//
// Source: M. Nesme, M. Marchal, E. Promayon, M. Chabanas, Y. Payan, F. Faure: Physically realistic interactive
// simulation for biological soft tissues (2005), appendix B. The cut into six and the attributes input, output and swapping are SOFA's.
//
// Example:
// <Node name="root">
//   <RegularGridTopology name="grid" n="3 3 3" min="0 0 0" max="1 1 1"/>
//   <Node name="body">
//     <TetrahedronSetTopologyContainer name="tets"/>
//     <Hexa2TetraTopologicalMapping input="@../grid" output="@tets" cutting="ten"/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include "components/topology/cell_cuts.h"
#include "framework/mesh/cell_attributes.h"
#include "framework/mesh/topology.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class Hexa2TetraTopologicalMapping : public TopologicalMapping {
 public:
  void declare(DataTable& table) override {
    table.addLink("input", input_).help("topology with hexahedra; without it, that of the nearest node above");
    table.addLink("output", output_).help("container to fill; by default the one in the same node, else the mapping itself");
    table.addChoice("cutting", cutting_, {"six", "five", "five1", "five2", "ten", "mirrored"}).help("how a hexahedron is cut");
    table.add("swapping", swapping_).help("mirror the cut into six from cell to cell (grids)");
    table.add("position", mesh_.position).alias("points").unit("m").help("nodes").output();
    addCellList(table, cell_kinds::tetrahedron, mesh_.tetrahedra).help("the tetrahedra").output();
    table.add("stiffnessScale", stiffness_scale_)
        .unit("-")
        .output()
        .help(
            "factor of the stiffness and mass of each cell: 0.5 for ten, else 1; applied by components that read the topology");
  }

  void init() override {
    const Topology* source = input_.target() ? input_.get() : topologyAbove();
    if (!source) throw ComponentError("there is no topology to cut", "input=\"@...\", or a topology in a node above");
    const Mesh& from = source->mesh();
    if (from.hexahedra.empty())
      throw ComponentError(fmt::format("{} has no hexahedra", source->path()), "a topology with hexahedra");
    if (output_.target() && output_.target() == input_.target())
      throw ComponentError("input and output are the same topology", "two topologies");
    mesh_.position = from.position;
    mesh_.tetrahedra = cutHexahedra(from.hexahedra, cutting_, swapping_);
    mesh_.overlap = from.overlap * (cutting_ == HexahedronCut::ten ? 2 : 1);
    stiffness_scale_ = 1 / mesh_.overlap;
    const Index cracks = mismatchedFaces(from.hexahedra, mesh_.tetrahedra, tetrahedraPerHexahedron(cutting_));
    if (cracks > 0)
      warn(fmt::format("{} inner faces are cut along different diagonals by their two cells: the body is weaker there",
                       cracks),
           "cutting=\"five\" or \"ten\"");
  }

 private:
  Topology* topologyAbove() const { return node().parent() ? node().parent()->find<Topology>(this, true) : nullptr; }

  HexahedronCut cutting_ = HexahedronCut::six;
  bool swapping_ = false;
  double stiffness_scale_ = 1;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(hexa2tetra_topological_mapping) {
  factory.add<stroma::Hexa2TetraTopologicalMapping>("Hexa2TetraTopologicalMapping", "cuts hexahedra into tetrahedra");
}
