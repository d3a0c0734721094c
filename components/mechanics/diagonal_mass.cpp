// SPDX-License-Identifier: LGPL-2.1-or-later
// DiagonalMass: each node carries its share of the mass of the cells around it.
//
//   m_i = sum over cells of rho * integral of N_i dV
//
// that is rho V / 4 at each node of a tetrahedron and, in a hexahedron, the integral by two Gauss points per axis
// (rho V / 8 in a box). These are the row sums of the consistent matrix of MeshMatrixMass. On a mesh without volumes
// rho is a mass per area (triangles and quads) or per length (edges). Where cells overlap, as when a body is cut into
// tetrahedra twice, each counts for its part.
//
// Of totalMass, massDensity and vertexMass the first that is given is used. Volumes are those of the rest shape unless
// computeMassOnRest="false".
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerExplicitSolver/>
//   <RegularGridTopology name="grid" n="4 3 3" min="0 0 0" max="0.3 0.2 0.2"/>
//   <MechanicalObject name="dofs"/>
//   <DiagonalMass massDensity="1000"/>
// </Node>
#include "components/mechanics/mesh_mass.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class DiagonalMass final : public MeshMass {
 public:
  void init() override {
    MeshMass::init();
    if (isNodal()) {
      masses_ = nodalMasses();
    } else {
      masses_.assign(state().size(), 0.0);
      forEachEntry([this](Index i, Index, double mass) { masses_[i] += mass; });
    }
    checkMasses(masses_);
    finish(masses_);
  }

  const std::vector<double>& lumped() const override { return masses_; }
  bool isDiagonal() const override { return true; }

 private:
  std::vector<double> masses_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(diagonal_mass) {
  factory.add<stroma::DiagonalMass>("DiagonalMass", "Nodal masses from the volumes of the cells and a density");
}
