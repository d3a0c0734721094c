// SPDX-License-Identifier: LGPL-2.1-or-later
// SparseGridTopology: the cells of a box that are inside a closed surface or cut by it.
//
// The box (min, max; if both are zero, the bounding box of the surface enlarged by 1 % on each side) has n nodes along its axes, or cells
// of size cellWidth. A cell that meets a triangle of the surface is a BORDER cell. A cell that can be reached from outside the box without
// crossing border cells is OUTSIDE. All others are INSIDE. Hexahedra: border cells in the order of the grid, then inside cells (with
// onlyInsideCells only these). Nodes: the corners in use, ascending in x, then y, then z.
//
// cellFactors is the filled part of each cell: 1 inside and 0.5 on the border, or 1 with fillWeighted="false". As
// localStiffnessFactor="@grid.cellFactors" of a force field it makes the border softer. nbVirtualFinerLevels = k classifies the cells of a
// grid that is 2^k times as fine: a cell is inside if all of its fine cells are, and on the border if some are inside or cut. Its factor is
// the mean of theirs. partFactors has the factors of the 8^partLevels parts of each cell, x fastest, for NonUniformHexahedronFEMForceField;
// with partLevels="0" they are cellFactors.
//
// SparseGridRamificationTopology keeps parts of the body apart that are side by side in one cell, such as two fingers. Fine cells are
// neighbours if they share a side and, with finestConnectivity, one of them is inside or a triangle meets both. A cell has a copy with its
// own nodes for each group of its fine cells that are connected. Copies share nodes where fine cells of both are neighbours. Nodes at the
// same place are consecutive.
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
