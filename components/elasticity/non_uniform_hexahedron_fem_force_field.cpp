// SPDX-License-Identifier: LGPL-2.1-or-later
// NonUniformHexahedronFEMForceField: trilinear hexahedra that are filled unevenly with material. A cell has 1, 8, 64, 512 or
// 4096 parts of equal size in the coordinates of the cell (x fastest), and a factor on the stiffness of each of them. With R
// the rotation of a cell, X its nodes at rest, n_a the gradients of its shape functions there, and s_p the factor of part p,
//
//   f = -R K (R^T x - X),   K_ab = sum over parts of s_p * integral over p of lambda n_a n_b^T + mu n_b n_a^T + mu (n_a . n_b) I
//
// by eight Gauss points in each part. This is the stiffness of a fine mesh of the parts with nodes mapped to those of the
// cell: coarse cells account for the distribution of material, but still lock.
//
// HexahedronCompositeFEMForceField lets the parts deform relative to each other: from the finest level on, the 27 nodes of
// eight cells that lie in one follow its eight corners, and K of the one is W^T K W. W is where the 19 others come to rest
// when the corners move, of which each node keeps what moves it along the same axis, from the ends of its edge, the corners of
// its face or all eight; the weights of a node are then divided by their sum. Empty parts are rigid there and contribute
// nothing to K. Full cells are the same as above; a cell with a soft and a hard half has the right stiffness, and so do two
// thin rods in one cell. With uneven weights K also resists small rotations, because of the weights that were left out: the
// tangent -R K R^T is then not the derivative of the force, even at rest, but with method small.
//
// R belongs to F = [means of the four edges in each direction, now] [at rest]^-1: method large takes its QR factor, polar its polar
// factor, small none. With polarOf = edges it is the product of the polar factors of the edges now and, transposed, at rest. The
// tangent is -R K R^T.
//
// Source: M. Nesme, Y. Payan, F. Faure: Animating shapes at arbitrary resolution with non-uniform stiffness (2006). SOFA's
// NonUniformHexahedronFEMForceFieldAndMass is this field and a MeshMatrixMass with the same factors. Composite cells: M. Nesme,
// P. Kry, L. Jerabkova, F. Faure: Preserving topology and elasticity for embedded deformable models (2009), by SOFA's rules.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="100" tolerance="1e-10"/>
//   <SparseGridTopology name="grid" n="3 3 3" nbVirtualFinerLevels="2" partLevels="1"
//     position="0 0 0  1 0 0  0 1 0  0 0 1" triangles="0 2 1  0 1 3  1 2 3  2 0 3"/>
//   <MechanicalObject/>
//   <UniformMass totalMass="1"/>
//   <NonUniformHexahedronFEMForceField youngModulus="1e4" poissonRatio="0.3" partFactors="@grid.partFactors"/>
//   <FixedProjectiveConstraint indices="0 1"/>
//   <Node name="soft">
//     <RegularGridTopology n="2 2 2" min="2 0 0" max="3 1 1"/>
//     <MechanicalObject/>
//     <UniformMass totalMass="1"/>
//     <HexahedronCompositeFEMForceField method="small" youngModulus="1e4" poissonRatio="0.3"
//       partFactors="1 0.01 1 0.01 1 0.01 1 0.01"/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "components/elasticity/parts_of_cells.h"
#include "components/elasticity/rotation_methods.h"
#include "framework/fem/eigen_matrix.h"
#include "framework/mechanics/node_group_field.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_kind.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

using parts::CellStiffness;
using parts::corner_places;
using parts::Corners;

/// Means of the four edges in each direction.
template <class At>
Mat3 meanEdgesOf(At&& at) {
  Mat3 edges = Mat3::Zero();
  for (int a = 0; a < 8; ++a)
    for (int axis = 0; axis < 3; ++axis) edges.col(axis) += (corner_places[a][axis] ? 0.25 : -0.25) * at(a);
  return edges;
}

class NonUniformHexahedra final : public NodeGroupField<8> {
 public:
  bool condenses = false;  ///< set by the registration of a name

  void declare(DataTable& table) override {
    ForceField::declare(table);
    topology_.declare(table, "mesh of hexahedra");
    table.add("youngModulus", young_)
        .recompiled()
        .help("Young's modulus where the factor is 1")
        .unit("Pa")
        .min(0, false)
        .physical();
    table.add("poissonRatio", poisson_)
        .recompiled()
        .help("Poisson's ratio")
        .unit("-")
        .min(-1, false)
        .max(0.5, false)
        .physical();
    table.add("partFactors", factors_)
        .recompiled()
        .help("factor on the stiffness of each part of each cell, as many parts in all cells; empty: 1")
        .unit("-")
        .min(0);
    table.addChoice("method", method_, {"small", "large", "polar"})
        .help("how a cell's rotation is found: small (none), large (QR), polar");
    table.addChoice("polarOf", polar_of_, {"gradient", "edges"})
        .help("of method polar: the matrix whose polar factor turns a cell, F or (SOFA) that of its edges");
    for (const char* name : {"drawing", "drawPercentageOffset"}) table.addVisualOnly(name);
  }

  void init() override {
    ForceField::init();
    cells_ = topology_.meshWith(cell_kinds::hexahedron, *this, state()).hexahedra;
    partsAlong();
  }

  ForceTraits traits() const override {
    ForceTraits traits;
    const bool linear = method_ == Method::small;
    traits.linear = traits.constant_stiffness = traits.conservative = traits.exact_tangent = linear;
    traits.symmetric = traits.forces_balance = traits.has_rest_shape = true;
    return traits;
  }

  void compile() override {
    std::vector<Group> rows;
    for (const Hexahedron& cell : cells_) {
      rows.push_back(cell);
      for (Index& row : rows.back()) row += state().firstRow();
    }
    setGroups(std::move(rows), false);
    findStiffness();
    rotations_.assign(cells_.size(), Mat3::Identity());
    outdateTangents();
  }

  double energy(ConstRows x) const override {
    double sum = 0;
    for (std::size_t e = 0; e < cells_.size(); ++e) {
      const CellVector u = strained(e, rotationOf(e, x), x);
      sum += u.dot(own_[e] * u) / 2;
    }
    return sum;
  }

  void addForce(ConstRows x, ConstRows, Rows f) override {
    for (std::size_t e = 0; e < cells_.size(); ++e) {
      const Mat3& r = rotations_[e] = rotationOf(e, x);
      const CellVector local = own_[e] * strained(e, r, x);
      for (int a = 0; a < 8; ++a) f[rows_[e][std::size_t(a)]] -= r * local.segment<3>(3 * a);
    }
    outdateTangents();
  }

 protected:
  void computeTangents() const override {
    for (std::size_t e = 0; e < cells_.size(); ++e)
      for (int a = 0; a < 8; ++a)
        for (int b = 0; b < 8; ++b)
          stiffness_[e].block(a, b) = -(rotations_[e] * own_[e].block<3, 3>(3 * a, 3 * b) * rotations_[e].transpose());
  }

 private:
  using CellVector = Eigen::Matrix<double, 24, 1>;

  /// How many parts lie side by side in a cell.
  int partsAlong() const {
    if (factors_.empty()) return 1;
    constexpr std::size_t most = 16;  // the matrices of the parts of one cell are kept, 19 MB
    for (std::size_t n = 1; n <= most; n *= 2)
      if (factors_.size() == n * n * n * cells_.size()) return int(n);
    throw ComponentError(fmt::format("partFactors has {} values for {} cells", factors_.size(), cells_.size()),
                         "1, 8, 64, 512 or 4096 for each cell");
  }
  Corners cornersOf(std::size_t e) const {
    Corners corners;
    for (std::size_t a = 0; a < 8; ++a) corners[a] = state().rest_position[std::size_t(cells_[e][a])];
    return corners;
  }

  void findStiffness() {
    const Lame material = Lame::from(young_, poisson_);
    const int n = partsAlong();
    const auto count = std::size_t(n * n * n);
    own_.assign(cells_.size(), CellStiffness::Zero());
    rest_edges_.clear();
    if (condenses && n > 1) return condense(material, n);
    std::vector<CellStiffness> of_parts;
    CellStiffness whole = CellStiffness::Zero();
    Corners shape;  // whose parts these are
    for (std::size_t e = 0; e < cells_.size(); ++e) {
      const Corners corners = cornersOf(e);
      rest_edges_.push_back(meanEdgesOf([&](int a) { return corners[std::size_t(a)]; }).inverse());
      if (of_parts.empty() || !isMoved(shape, corners)) {
        shape = corners, of_parts.clear();
        for (std::size_t p = 0; p < count; ++p) {
          const int at = int(p);
          of_parts.push_back(parts::partStiffness(corners, Vec3(at % n, at / n % n, at / n / n) / n, n, material));
        }
        whole.setZero();
        for (const CellStiffness& k : of_parts) whole += k;
      }
      const double* factor = factors_.empty() ? nullptr : factors_.data() + e * count;
      if (!factor || std::all_of(factor, factor + count, [&](double s) { return s == factor[0]; })) {
        own_[e] = (factor ? factor[0] : 1) * whole;
        continue;
      }
      for (std::size_t p = 0; p < count; ++p)
        if (factor[p] != 0) own_[e] += factor[p] * of_parts[p];
    }
  }
  void condense(const Lame& material, int n) {
    const auto count = std::size_t(n * n * n);
    const std::vector<double> full(count, 1);
    CellStiffness whole = CellStiffness::Zero();
    Corners shape;  // whose matrix that is
    bool has_whole = false;
    for (std::size_t e = 0; e < cells_.size(); ++e) {
      const Corners corners = cornersOf(e);
      rest_edges_.push_back(meanEdgesOf([&](int a) { return corners[std::size_t(a)]; }).inverse());
      const double* factor = factors_.data() + e * count;
      if (!std::all_of(factor, factor + count, [&](double s) { return s == factor[0]; })) {
        own_[e] = parts::Composite(corners, factor, n, material).stiffness();
        continue;
      }
      if (!has_whole || isMoved(shape, corners))
        whole = parts::Composite(corners, full.data(), n, material).stiffness(), shape = corners, has_whole = true;
      own_[e] = factor[0] * whole;
    }
  }
  /// The same shape in another place, but for round-off.
  static bool isMoved(const Corners& a, const Corners& b) {
    constexpr double round_off = 1e-12;
    for (std::size_t i = 1; i < 8; ++i)
      if (!((a[i] - a[0]) - (b[i] - b[0])).isZero(round_off * (a[6] - a[0]).norm())) return false;
    return true;
  }

  Mat3 rotationOf(std::size_t e, ConstRows x) const {
    if (method_ == Method::small) return Mat3::Identity();
    const Mat3 edges = meanEdgesOf([&](int a) { return Vec3(x[rows_[e][std::size_t(a)]]); });
    const auto polar = [](const Mat3& m) { return toEigen(rotation::Polar::of(fromEigen(m))); };
    if (method_ == Method::large) return toEigen(rotation::Qr::of(fromEigen(edges * rest_edges_[e])));
    const auto factor = [](const Mat3& m) { return toEigen(rotation::orthogonalFactor(fromEigen(m))); };
    if (polar_of_ == PolarOf::edges) return factor(edges) * factor(rest_edges_[e].inverse()).transpose();
    return polar(edges * rest_edges_[e]);
  }
  /// R^T x - X of the corners.
  CellVector strained(std::size_t e, const Mat3& r, ConstRows x) const {
    CellVector u;
    for (int a = 0; a < 8; ++a) {
      const Vec3& rest = state().rest_position[std::size_t(cells_[e][std::size_t(a)])];
      u.segment<3>(3 * a) = r.transpose() * Vec3(x[rows_[e][std::size_t(a)]]) - rest;
    }
    return u;
  }

  TopologyLink topology_;
  enum class Method : int { small, large, polar } method_ = Method::large;
  enum class PolarOf : int { gradient, edges } polar_of_ = PolarOf::gradient;
  double young_ = 5000, poisson_ = 0.45;
  std::vector<double> factors_;
  std::vector<Hexahedron> cells_;
  std::vector<CellStiffness> own_;  ///< K of each cell at rest [N/m]
  std::vector<Mat3> rest_edges_;    ///< inverses of the mean edges at rest [1/m]
  std::vector<Mat3> rotations_;     ///< of the last addForce()
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(non_uniform_hexahedron_fem_force_field) {
  factory.add<stroma::NonUniformHexahedra>("NonUniformHexahedronFEMForceField", "trilinear hexahedra that are filled unevenly");
  factory.add<stroma::NonUniformHexahedra>("HexahedronCompositeFEMForceField", "hexahedra of parts that yield to each other",
                                           [](stroma::NonUniformHexahedra& field) { field.condenses = true; });
}
