// SPDX-License-Identifier: LGPL-2.1-or-later
// SparseGridTopology: the cells of a box that lie in a closed surface, or that the surface goes through.
//
// The box (min, max; that of the surface grown by 1 % on each side when both are zero) has n nodes along its axes, or cells of
// the size cellWidth. A cell that a triangle of the surface meets is a BORDER cell; one that is reached from outside of the
// box without crossing border cells lies OUTSIDE; all others lie INSIDE. Hexahedra: border cells in the order of the grid, then
// inside cells (those alone with onlyInsideCells). Nodes: the corners in use, ascending in x, then y, then z.
//
// cellFactors is how much of a cell the body fills, 1 inside and 0.5 on the border; with fillWeighted="false" 1. As
// localStiffnessFactor="@grid.cellFactors" of a force field it makes the border softer. With nbVirtualFinerLevels k the surface
// is looked at on a grid that is 2^k times as fine: a cell lies inside when all of its fine cells do, is on the border when some
// do or are cut, and its factor is the mean of theirs. partFactors are those of the 8^partLevels parts of each cell, x fastest, for
// NonUniformHexahedronFEMForceField: with partLevels="0" the same as cellFactors.
//
// SparseGridRamificationTopology does not join what lies side by side in one cell, as two fingers. Fine cells are neighbours when
// they have a side in common and, with finestConnectivity, one of them lies inside or a triangle meets both. A cell has a copy for
// each group of its fine cells that are neighbours, with nodes of its own, and copies share nodes where fine cells of both are
// neighbours. Nodes of equal places follow each other.
//
// Source: M. Nesme, Y. Payan, F. Faure: Animating shapes at arbitrary resolution with non-uniform stiffness (2006); names,
// attributes and the order of cells and nodes are SOFA's. Boxes and triangles: T. Akenine-Moller 2001.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="100" tolerance="1e-9"/>
//   <SparseGridTopology name="grid" n="5 5 5" position="0 0 0  1 0 0  0 1 0  0 0 1" triangles="0 2 1  0 1 3  1 2 3  2 0 3"/>
//   <MechanicalObject/>
//   <UniformMass totalMass="1"/>
//   <HexahedronFEMForceField youngModulus="1e4" poissonRatio="0.3" localStiffnessFactor="@grid.cellFactors"/>
//   <FixedProjectiveConstraint indices="0 1"/>
//   <Node name="fingers">
//     <SparseGridRamificationTopology n="3 2 2" nbVirtualFinerLevels="3" finestConnectivity="true"
//       position="0 0 3  1 0 3  0 0.4 3  0 0 4   0 0.6 3  1 0.6 3  0 1 3  0 0.6 4"
//       triangles="0 2 1  0 1 3  1 2 3  2 0 3   4 6 5  4 5 7  5 6 7  6 4 7"/>
//     <MechanicalObject/>
//     <UniformMass totalMass="1"/>
//     <HexahedronFEMForceField youngModulus="1e4" poissonRatio="0.3"/>
//   </Node>
// </Node>
#include "components/topology/sparse_grid.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class SparseGridRamificationTopology final : public SparseGridTopology {
 public:
  void declare(DataTable& table) override {
    SparseGridTopology::declare(table);
    table.add("finestConnectivity", by_triangles_).help("cells on the border are neighbours only where a triangle meets both");
  }

 protected:
  bool splitsCells() const override { return true; }
  bool looksAtTriangles() const override { return by_triangles_; }

 private:
  bool by_triangles_ = true;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(sparse_grid_topology) {
  factory.add<stroma::SparseGridTopology>("SparseGridTopology", "the cells of a box that lie in a surface");
  factory.add<stroma::SparseGridRamificationTopology>("SparseGridRamificationTopology",
                                                      "the same, with a copy of a cell for each part of the body in it");
}
