// SPDX-License-Identifier: LGPL-2.1-or-later
// DiagonalMass: each node carries its share of the mass of the cells around it.
//
//   m_i = sum over cells of rho * integral of N_i dV
//
// that is rho V / 4 at each node of a tetrahedron and, in a hexahedron, the integral by two Gauss points per axis
// (rho V / 8 in a box). These are the row sums of the consistent matrix of MeshMatrixMass. Those of a quadratic cell are
// negative at its corners: its mass m goes to the nodes in proportion to the diagonal of its consistent matrix,
//   m_i = m M_ii / sum_j M_jj
// (E. Hinton, T. Rock, O. C. Zienkiewicz 1976), in a straight quadratic tetrahedron m/36 at a corner and 4 m/27 at the middle
// of an edge: positive, and of the right sum. The weight m g acts at the nodes as these masses do. On a mesh without volumes
// rho is a mass per area (triangles and quads; of a sheet its density times its thickness) or per length (edges; of a beam its
// density times its cross-section), and an explicit unit must be one of these. Overlapping cells, as when a body is cut into
// tetrahedra twice, are weighted accordingly. With shares="equal", as in SOFA, all nodes of a cell have the same share, even
// if it is not a box or parallelogram, and a quad has the area of the two triangles along the diagonal from corner 0.
//
// The first given one of totalMass, massDensity and vertexMass is used. Volumes are those of the rest shape unless
// computeMassOnRest="false".
//
// Rigid frames (template Rigid3), the nodes of beams for instance, also have an inertia: `inertia` as in UniformMass, by
// default the mass of each times the unit matrix [m^2].
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerExplicitSolver/>
//   <RegularGridTopology name="grid" n="4 3 3" min="0 0 0" max="0.3 0.2 0.2"/>
//   <MechanicalObject name="dofs"/>
//   <DiagonalMass massDensity="1000"/>
// </Node>
#include "components/mechanics/frame_inertia.h"
#include "components/mechanics/mesh_mass.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class DiagonalMass final : public MeshMass {
 public:
  void declare(DataTable& table) override {
    MeshMass::declare(table);
    frames_.declare(table);
  }

  void init() override {
    MeshMass::init();
    if (isNodal()) {
      masses_ = nodalMasses();
    } else {
      masses_.assign(state().nodes(), 0.0);
      addLumped(masses_);
    }
    checkMasses(masses_);
    finish(masses_);
    if (state().hasPointsOnly()) return;
    std::vector<TurningInertia> turning;
    const std::vector<double> nodal = masses_;
    std::vector<Mat3> tensors;
    if (state().hasFrames()) tensors = frames_.tensors(*this, state(), nodal, Mat3::Identity());
    if (state().hasFrames() && !data().find("inertia")->isSet())
      inform("no inertia is given: that of a frame is its mass times 1 m^2 about each axis, as in SOFA");
    masses_ = FrameInertia::ofRows(state(), nodal, tensors, turning);
    setTurningInertias(std::move(turning));
  }

  const std::vector<double>& lumped() const override { return masses_; }
  bool isDiagonal() const override { return true; }

 protected:
  bool takesAllRows() const override { return true; }

 private:
  FrameInertia frames_;
  std::vector<double> masses_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(diagonal_mass) {
  factory.add<stroma::DiagonalMass>("DiagonalMass", "Nodal masses from the volumes of the cells and a density");
}
