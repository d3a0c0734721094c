// SPDX-License-Identifier: LGPL-2.1-or-later
// TetrahedronDiffusionFEMForceField: diffusion of a quantity in a body, such as heat or a concentration. Its values T are at the nodes of a
// state of template Vec1. The cells are linear tetrahedra between the rest positions of these nodes.
//
//   f_i = -sum over cells of V_c sum_j (grad N_i . D_c grad N_j) T_j
//
// D_c is a number. With a fibre direction d, along which it is r = anisotropyRatio times as large, it is D_c (1 + (r - 1) d d^T).
//
// With a MeshMatrixMass or a DiagonalMass of density rho on the values, and an integrator with firstOrder="true", this is
// rho dT/dt = div (D grad T), where D / rho is the diffusivity [m^2/s]. Without firstOrder it is a wave equation. Held values
// (FixedProjectiveConstraint) are boundary values. There is no flow through the rest of the surface.
//
// Positions are those of the state `mechanicalObject`, by default the nearest state of points above. The rest positions are used even if
// the body moves.
//
// Source: names and attributes are SOFA's. As in SOFA the length of d counts, so it should be 1. tagMechanics, by which SOFA finds the
// state with the positions, is ignored.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <TetrahedronSetTopologyContainer name="cells" position="0 0 0  1 0 0  0 1 0  0 0 1  1 1 1" tetrahedra="0 1 2 3  1 2 3 4"/>
//   <MechanicalObject name="places" position="@cells.position"/>
//   <Node name="heat">
//     <EulerImplicitSolver firstOrder="true"/>
//     <SparseLDLSolver/>
//     <MechanicalObject template="Vec1" position="1 0 0 0 0"/>
//     <DiagonalMass massDensity="1" topology="@../cells" geometryState="@../places"/>
//     <FixedProjectiveConstraint indices="0"/>
//     <TetrahedronDiffusionFEMForceField topology="@../cells" mechanicalObject="@../places" constantDiffusionCoefficient="0.1"/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include <Eigen/LU>
#include <array>
#include <cmath>

#include "framework/mechanics/node_group_field.h"
#include "framework/mechanics/node_indices.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_kind.h"
#include "framework/scene/factory.h"
#include "framework/scene/node.h"

namespace stroma {
namespace {

class TetrahedronDiffusion final : public NodeGroupField<4> {
 public:
  void declare(DataTable& table) override {
    ForceField::declare(table);
    topology_.declare(table, "mesh of tetrahedra");
    table.addLink("mechanicalObject", places_)
        .help("state with the positions of the nodes; by default the nearest one of points above");
    table.add("constantDiffusionCoefficient", coefficient_)
        .recompiled()
        .help("D of all tetrahedra: flow through an area over the gradient of the values")
        .unit("-")
        .min(0);
    table.add("tetrahedronDiffusionCoefficient", coefficients_)
        .alias("tetraDiffusionCoefficient")
        .ofCells()
        .help("D per cell, a tetrahedron, instead")
        .unit("-")
        .min(0);
    table.add("anisotropyRatio", ratio_).help("D along fibres over that across").unit("-").min(0);
    table.add("transverseAnisotropyArray", fibres_)
        .ofCells()
        .help("with a ratio: direction of the fibres per cell, or one for all")
        .unit("-");
    for (const char* name : {"tagMechanics", "drawConduc", "tetraInfo", "edgeInfo", "scalarDiffusion"})
      table.addVisualOnly(name);
  }

  void init() override {
    ForceField::init();
    if (state().hasPointsOnly() || state().rows_per_node != 1 || state().kindOf(0) != RowKind::value)
      throw ComponentError(fmt::format("the nodes of {} are no single numbers", state().path()), "a state of template Vec1");
    if (coefficients_.empty() && !data().find("constantDiffusionCoefficient")->isSet())
      warn("constantDiffusionCoefficient is not given: the default 1 is used");
    const State* places = placesOfNodes();
    if (places->nodes() != state().nodes())
      throw ComponentError(
          fmt::format("{} has {} nodes and {} has {}", places->path(), places->nodes(), state().path(), state().nodes()),
          "as many");
    rest_ = &places->rest_position;
    cells_ = topology_.meshWith(cell_kinds::tetrahedron, *this, state()).tetrahedra;
    if (coefficients_.size() > 1 && coefficients_.size() != cells_.size())
      throw ComponentError(
          fmt::format("tetrahedronDiffusionCoefficient has {} values for {} tetrahedra", coefficients_.size(), cells_.size()),
          fmt::format("none, one or {}", cells_.size()));
    checkFibres();
    for (std::size_t e = 0; e < cells_.size(); ++e) edgesOf(e);
  }

  ForceTraits traits() const override {
    ForceTraits traits;
    traits.linear = traits.constant_stiffness = traits.symmetric = traits.conservative = traits.exact_tangent = true;
    traits.forces_balance = true;
    return traits;
  }

  void compile() override {
    std::vector<Group> rows;
    for (const Tetrahedron& cell : cells_) {
      rows.push_back(cell);
      for (Index& row : rows.back()) row += state().firstRow();
    }
    setGroups(std::move(rows), false);
    for (std::size_t e = 0; e < cells_.size(); ++e) assemble(e);
  }

  double energy(ConstRows x) const override {
    double sum = 0;
    for (std::size_t e = 0; e < cells_.size(); ++e)
      for (int a = 0; a < 4; ++a)
        for (int b = 0; b < 4; ++b) sum -= entry(e, a, b) * valueOf(e, a, x) * valueOf(e, b, x) / 2;
    return sum;
  }
  void addForce(ConstRows x, ConstRows, Rows f) override {
    for (std::size_t e = 0; e < cells_.size(); ++e)
      for (int a = 0; a < 4; ++a) {
        double sum = 0;
        for (int b = 0; b < 4; ++b) sum += entry(e, a, b) * valueOf(e, b, x);
        f[rows_[e][std::size_t(a)]] += sum * Vec3::UnitX();
      }
  }

 protected:
  bool takesAllRows() const override { return true; }

 private:
  void checkFibres() {
    if (ratio_ == 1) return;
    if (fibres_.size() != 1 && fibres_.size() != cells_.size())
      throw ComponentError(
          fmt::format("transverseAnisotropyArray has {} directions for {} tetrahedra", fibres_.size(), cells_.size()),
          fmt::format("one or {}", cells_.size()));
    constexpr double written = 1e-3;  // of a direction of few digits
    for (const Vec3& d : fibres_)
      if (1 + (ratio_ - 1) * d.squaredNorm() < 0)
        throw ComponentError(fmt::format("a direction of transverseAnisotropyArray has the length {:.3g}: the diffusion along it is "
                                         "negative", d.norm()), "directions of length 1");
    for (const Vec3& d : fibres_)
      if (std::abs(d.norm() - 1) > written)
        return warn(fmt::format("a direction of transverseAnisotropyArray has the length {:.3g}, which scales the diffusion", d.norm()));
  }
  const State* placesOfNodes() const {
    if (State* given = places_.get()) {
      given->ensureReady();
      if (given->hasPointsOnly()) return given;
      throw ComponentError(fmt::format("mechanicalObject: the nodes of {} are no points", given->path()),
                           "a state of template Vec3");
    }
    for (const Node* above = node().parent(); above; above = above->parent())
      for (const auto& component : above->components()) {
        auto* found = dynamic_cast<State*>(component.get());
        if (!found) continue;
        found->ensureReady();
        if (found->hasPointsOnly()) return found;
      }
    throw ComponentError("there is no state of points with the positions of the nodes",
                         "one in a node above, or mechanicalObject=\"@...\"");
  }
  double entry(std::size_t e, int a, int b) const { return stiffness_[e].blocks[std::size_t(4 * a + b)](0, 0); }
  double valueOf(std::size_t e, int corner, ConstRows x) const { return Vec3(x[rows_[e][std::size_t(corner)]])[0]; }
  /// Those at corner 0, at rest. Throws where the cell has no volume.
  Mat3 edgesOf(std::size_t e) const {
    const auto at = [&](int corner) -> const Vec3& { return (*rest_)[std::size_t(cells_[e][std::size_t(corner)])]; };
    Mat3 edges;
    for (int c = 0; c < 3; ++c) edges.col(c) = at(c + 1) - at(0);
    const double volume = edges.determinant() / 6;
    if (!(volume > 0))
      throw ComponentError(fmt::format("tetrahedron {} has a volume of {:.3g} m^3 at rest", e, volume), "one above 0");
    return edges;
  }
  void assemble(std::size_t e) {
    const Mat3 edges = edgesOf(e);
    const double volume = edges.determinant() / 6;
    const Mat3 inverse = edges.inverse();
    std::array<Vec3, 4> g;
    for (int c = 0; c < 3; ++c) g[std::size_t(c + 1)] = inverse.row(c).transpose();
    g[0] = -(g[1] + g[2] + g[3]);
    const double d = coefficients_.empty() ? coefficient_ : coefficients_[coefficients_.size() > 1 ? e : 0];
    Mat3 along = Mat3::Identity();
    if (ratio_ != 1) {
      const Vec3& fibre = fibres_[fibres_.size() > 1 ? e : 0];
      along += (ratio_ - 1) * fibre * fibre.transpose();
    }
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < 4; ++b) stiffness_[e].block(a, b)(0, 0) = -d * volume * g[std::size_t(a)].dot(along * g[std::size_t(b)]);
  }

  TopologyLink topology_;
  Link<State> places_{"mechanical state"};
  double coefficient_ = 1, ratio_ = 1;
  std::vector<double> coefficients_;
  std::vector<Vec3> fibres_;
  std::vector<Tetrahedron> cells_;
  const std::vector<Vec3>* rest_ = nullptr;  ///< of the state of the places
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(tetrahedron_diffusion_fem_force_field) {
  factory.add<stroma::TetrahedronDiffusion>("TetrahedronDiffusionFEMForceField",
                                            "heat or a concentration that spreads in tetrahedra");
}
