// SPDX-License-Identifier: LGPL-2.1-or-later
// QuadBendingFEMForceField: a plate of rectangles that resists strains in its plane and shear across it, for small displacements.
//
//   f = -K u,   u = x - x0
//   in the plane:  K_ij = a b sum over 2x2 points of B_i^T C B_j,   C = E t/(1 - nu^2) [1 nu 0; nu 1 0; 0 0 (1 - nu)/2]
//   across it:     K_ij = 4 a b k G t (g_i . g_j),   g of the middle,   k = 5/6,   G = E/(2 (1 + nu))
//
// with half of the sides a (of nodes 0 and 1) and b (of nodes 0 and 3), the thickness t, and g_i and B_i the gradients and the
// strains of the bilinear shape functions. It is a Mindlin plate without rotational degrees of freedom: all bending is shear,
// so that it is far too stiff in bending, and has no stiffness in the chequerboard mode. A triangle membrane with bending
// springs is a better plate. A rigid rotation causes strain here.
//
// axes="cell": displacements are taken along the two sides of a cell at rest, and across them. "world": along x, y and z, whatever
// way the plate lies. strain="rest": the sides are those at rest; "current": those of the moment, in the force and in the tangent,
// which does not know that they change. SOFA has world and current.
//
// Source: Mindlin's plate, as in Zienkiewicz and Taylor, The finite element method, vol. 2; the name and what is left out of it are
// SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 -9.81">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="100" tolerance="1e-10"/>
//   <RegularGridTopology n="4 3 1" min="0 0 0" max="0.3 0.2 0"/>
//   <MechanicalObject/>
//   <UniformMass totalMass="0.1"/>
//   <FixedProjectiveConstraint indices="0 4 8"/>
//   <QuadBendingFEMForceField youngModulus="1e5" poissonRatio="0.3" thickness="0.01"/>
// </Node>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>

#include "components/elasticity/flat_cells.h"
#include "framework/mesh/cell_kind.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class QuadBending final : public FlatCells<4> {
 public:
  QuadBending() { poisson_ = 0.45; }
  void declare(DataTable& table) override {
    declareSheet(table, "plate");
    table.addChoice("axes", axes_, {"cell", "world"}).help("of displacements: those of each cell at rest, or x, y and z");
    table.addChoice("strain", strain_, {"rest", "current"}).help("by the sides at rest, or by those of the moment");
    for (const char* internal : {"quadInfo", "vertexInfo", "edgeInfo", "method"}) table.addVisualOnly(internal);
  }

  void init() override {
    ForceField::init();
    cells_ = topology_.meshWith(cell_kinds::quad, *this, state()).quads;
    frames_.clear();
    for (std::size_t e = 0; e < cells_.size(); ++e) frames_.push_back(frameOf(e));
  }

  ForceTraits traits() const override {
    ForceTraits traits;
    const bool is_fixed = strain_ == Strain::rest;
    traits.linear = traits.constant_stiffness = traits.conservative = traits.exact_tangent = is_fixed;
    traits.symmetric = traits.forces_balance = traits.has_rest_shape = true;
    return traits;
  }

  void compile() override {
    setCellGroups();
    for (std::size_t e = 0; e < cells_.size(); ++e)
      assemble(e, (restOf(e, 1) - restOf(e, 0)).norm() / 2, (restOf(e, 3) - restOf(e, 0)).norm() / 2);
  }

  void addForce(ConstRows x, ConstRows, Rows f) override {
    for (std::size_t e = 0; e < cells_.size(); ++e) {
      if (strain_ == Strain::current) {
        const Vec3 corner = x[rows_[e][0]];
        assemble(e, (Vec3(x[rows_[e][1]]) - corner).norm() / 2, (Vec3(x[rows_[e][3]]) - corner).norm() / 2);
      }
      addForceOf(e, x, f);
    }
  }

 private:
  enum class Axes { cell, world };
  enum class Strain { rest, current };

  /// Columns: along both sides and across them.
  Mat3 frameOf(std::size_t e) const {
    const Vec3 a = restOf(e, 1) - restOf(e, 0), b = restOf(e, 3) - restOf(e, 0);
    if (!(a.cross(b).norm() > 0)) throw ComponentError(fmt::format("quad {} has no area at rest", e), "rectangles");
    if (axes_ == Axes::world) return Mat3::Identity();
    constexpr double skew = 1e-6;
    const Vec3 other = restOf(e, 0) + a + b - restOf(e, 2);
    if (std::abs(a.dot(b)) > skew * a.norm() * b.norm() || other.norm() > skew * (a.norm() + b.norm()))
      throw ComponentError(fmt::format("quad {} is no rectangle at rest", e),
                           "rectangles; or triangles under a TriangularFEMForceField with bending springs");
    Mat3 frame;
    frame << a.normalized(), b.normalized(), a.cross(b).normalized();
    return frame;
  }

  /// K of a rectangle of 2 a x 2 b.
  void assemble(std::size_t e, double a, double b) {
    static constexpr double xs[4] = {-1, 1, 1, -1}, ys[4] = {-1, -1, 1, 1};
    const double plane = young_ * thickness_ / (1 - poisson_ * poisson_);
    const double slide = plane * (1 - poisson_) / 2;
    const double across = 5. / 6 * young_ * thickness_ / (2 * (1 + poisson_));
    const double point = std::sqrt(3.) / 3;
    std::array<Mat3, 16> blocks;
    blocks.fill(Mat3::Zero());
    for (int q = 0; q < 4; ++q) {
      double gx[4], gy[4];
      for (int i = 0; i < 4; ++i) {
        gx[i] = xs[i] * (1 + ys[i] * ys[q] * point) / (4 * a);
        gy[i] = ys[i] * (1 + xs[i] * xs[q] * point) / (4 * b);
      }
      for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) {
          Mat3& k = blocks[std::size_t(4 * i + j)];
          k(0, 0) += a * b * (plane * gx[i] * gx[j] + slide * gy[i] * gy[j]);
          k(1, 1) += a * b * (plane * gy[i] * gy[j] + slide * gx[i] * gx[j]);
          k(0, 1) += a * b * (poisson_ * plane * gx[i] * gy[j] + slide * gy[i] * gx[j]);
          k(1, 0) += a * b * (poisson_ * plane * gy[i] * gx[j] + slide * gx[i] * gy[j]);
        }
    }
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) {
        Mat3& k = blocks[std::size_t(4 * i + j)];
        k(2, 2) = 4 * a * b * across * (xs[i] * xs[j] / (16 * a * a) + ys[i] * ys[j] / (16 * b * b));
        stiffness_[e].block(i, j) = -(frames_[e] * k * frames_[e].transpose());
      }
  }

  Axes axes_ = Axes::cell;
  Strain strain_ = Strain::rest;
  std::vector<Mat3> frames_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(quad_bending_fem_force_field) {
  factory.add<stroma::QuadBending>("QuadBendingFEMForceField", "a plate of rectangles for small displacements");
}
