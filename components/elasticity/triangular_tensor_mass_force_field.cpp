// SPDX-License-Identifier: LGPL-2.1-or-later
// TriangularTensorMassForceField: a linear membrane that also resists displacements across its triangles, as if it were taut.
//
//   f = K (x - x0),   K_ab = -A [lambda g_a g_b^T + mu g_b g_a^T + (g_a.g_b) (mu P + (lambda + 2 mu) n n^T)]
//   lambda = E h nu / (1 - nu^2),   mu = E h / (2 (1 + nu)),   P = I - n n^T
//
// with A the area, n the normal and g_a the gradients of the shape functions of each triangle, all at rest, and h the
// thickness. In the plane it is the small strain of plane stress; across it the membrane is under the tension lambda + 2 mu. K
// does not change and does not turn: a body that turns is strained. E = -1/2 (x - x0)^T K (x - x0).
//
// Source: Cotin, Delingette and Ayache 2000, "A hybrid elastic model for real-time cutting, deformations, and force feedback";
// name and attributes are SOFA's, but for thickness (1 there).
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 -9.81">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="100" tolerance="1e-10"/>
//   <MeshTopology position="0 0 0  1 0 0  0.5 1 0  0.5 -1 0.2" triangles="0 1 2  1 0 3"/>
//   <MechanicalObject/>
//   <UniformMass totalMass="0.1"/>
//   <FixedProjectiveConstraint indices="0 1"/>
//   <TriangularTensorMassForceField youngModulus="1e4" poissonRatio="0.3" thickness="0.01"/>
// </Node>
#include <fmt/format.h>

#include <Eigen/Geometry>

#include "components/elasticity/flat_cells.h"
#include "framework/mesh/cell_kind.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class TriangularTensorMass final : public FlatCells<3> {
 public:
  void declare(DataTable& table) override { declareSheet(table, "membrane"); }

  void init() override {
    ForceField::init();
    cells_ = topology_.meshWith(cell_kinds::triangle, *this, state()).triangles;
    for (std::size_t e = 0; e < cells_.size(); ++e)
      if (!(normalOf(e).norm() > 0))
        throw ComponentError(fmt::format("triangle {} has no area at rest", e), "triangles with three corners apart");
  }

  ForceTraits traits() const override {
    ForceTraits traits;
    traits.linear = traits.constant_stiffness = traits.symmetric = traits.conservative = traits.exact_tangent = true;
    traits.forces_balance = traits.has_rest_shape = true;
    return traits;
  }

  void compile() override {
    setCellGroups();
    for (std::size_t e = 0; e < cells_.size(); ++e) assemble(e);
  }

 private:
  Vec3 normalOf(std::size_t e) const { return (restOf(e, 1) - restOf(e, 0)).cross(restOf(e, 2) - restOf(e, 0)); }
  void assemble(std::size_t e) {
    const double lambda = young_ * thickness_ * poisson_ / (1 - poisson_ * poisson_);
    const double mu = young_ * thickness_ / (2 * (1 + poisson_));
    const Vec3 normal = normalOf(e);
    const double area = normal.norm() / 2;
    const Vec3 n = normal / (2 * area);
    const Mat3 across = n * n.transpose(), plane = Mat3::Identity() - across;
    std::array<Vec3, 3> g;
    for (int a = 0; a < 3; ++a) g[std::size_t(a)] = n.cross(restOf(e, a + 2) - restOf(e, a + 1)) / (2 * area);
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) {
        const Vec3 &ga = g[std::size_t(a)], &gb = g[std::size_t(b)];
        stiffness_[e].block(a, b) = -area * (lambda * ga * gb.transpose() + mu * gb * ga.transpose() +
                                             ga.dot(gb) * (mu * plane + (lambda + 2 * mu) * across));
      }
  }
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(triangular_tensor_mass_force_field) {
  factory.add<stroma::TriangularTensorMass>("TriangularTensorMassForceField", "a linear membrane under tension");
}
