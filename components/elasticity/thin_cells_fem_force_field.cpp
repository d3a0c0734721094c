// SPDX-License-Identifier: LGPL-2.1-or-later
// ThinCellsFEMForceField: linear elastic edges, triangles or quads as parts of a body of one thickness, with or without rotations.
//
//   f = R K (X - c_0 - R^T (x - c)),   df = -R K R^T dx,   K = sum over points of w t sqrt(det J^T J) B^T D B
//   J = sum_a X_a dN_a/dxi,   dN_a/dX = J (J^T J)^-1 dN_a/dxi,   eps_ij = (du_i/dX_j + du_j/dX_i)/2,   sigma = lambda tr(eps) I + 2 mu eps
//
// with the places at rest X, centroids c and c_0, the thickness t (of edges the section t^2), and the strains B of all three directions
// of space. lambda is that of plane strain, E nu / ((1 + nu)(1 - 2 nu)), or with planeStress that of a sheet, E nu / ((1 + nu)(1 - nu));
// mu is E / (2 (1 + nu)). Across a cell only shear resists: a sheet has no stiffness of its own against bending.
// Edges and triangles have one point, quads the three (sqrt(2/3), 0), (-1/sqrt 6, +-1/sqrt 2).
//
// rotation="none": R = I, linear; a body that turns is strained. "nodes": R is the best fit of the nodes; "frame": that of the first
// edge and the plane of the first three nodes. With a rotation forces are none of an energy, and df, which holds R, resists turns out
// of the plane that the force does not: Newton's method is slow there. Both are SOFA's.
// TriangularFEMForceField is the better membrane (plane stress, a thickness, balanced torques) and SpringForceField the better line.
// It is SOFA's CorotationalFEMForceField or LinearSmallStrainFEMForceField with template="Vec3,Triangle", Vec3,Quad or Vec3,Edge,
// which have thickness="1".
//
// Source: the isoparametric cells of Zienkiewicz and Taylor, The finite element method, vol. 1; what of a cell resists is SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 -9.81">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="100" tolerance="1e-10"/>
//   <MeshTopology position="0 0 0  1 0 0  0.5 1 0  0.5 -1 0.2" triangles="0 1 2  1 0 3"/>
//   <MechanicalObject/>
//   <UniformMass totalMass="0.1"/>
//   <FixedProjectiveConstraint indices="0 1"/>
//   <ThinCellsFEMForceField cells="triangles" youngModulus="1e4" poissonRatio="0.3" thickness="0.01"/>
// </Node>
#include <fmt/format.h>

#include <Eigen/Dense>
#include <cmath>

#include "framework/fem/local_frame.h"
#include "framework/mechanics/node_group_field.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_kind.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

constexpr int most_corners = 4;

/// K of up to four corners.
struct CellTangent : DenseTangent<most_corners> {
  int corners = most_corners;
  void addProduct(const std::array<Index, most_corners>& rows, ConstRows dx, double factor, Rows df) const {
    for (int i = 0; i < corners; ++i) {
      Vec3 sum = Vec3::Zero();
      for (int j = 0; j < corners; ++j) sum += block(i, j) * dx[rows[std::size_t(j)]];
      df[rows[std::size_t(i)]] += factor * sum;
    }
  }
};

class ThinCells final : public NodeGroupField<most_corners, CellTangent> {
 public:
  void declare(DataTable& table) override {
    ForceField::declare(table);
    topology_.declare(table, "mesh that holds the cells");
    table.addChoice("cells", kind_, {"triangles", "quads", "edges"}).help("which cells of the mesh");
    table.addChoice("rotation", rotation_, {"none", "nodes", "frame"})
        .help("taken out of a cell: none, the best fit of its nodes, or that of its first edge and plane");
    table.add("youngModulus", young_).recompiled().help("Young's modulus: one for all, or one for each cell").unit("Pa").min(0).physical();
    table.add("poissonRatio", poisson_)
        .recompiled()
        .help("Poisson's ratio: one for all, or one for each cell")
        .unit("-")
        .min(-1, false)
        .max(0.5, false)
        .physical();
    table.add("thickness", thickness_).recompiled().help("of the sheet, or width and height of an edge").unit("m").min(0, false).physical();
    table.add("planeStress", plane_stress_).recompiled().help("lambda of a sheet whose faces are free, else that of plane strain");
    table.add("firstForOthers", first_for_others_).help("cells beyond the end of a list of values have its first, as in SOFA");
  }

  void init() override {
    ForceField::init();
    const CellKind& kind = kind_ == Cells::edges ? cell_kinds::edge : kind_ == Cells::quads ? cell_kinds::quad : cell_kinds::triangle;
    const Mesh& mesh = topology_.meshWith(kind, *this, state());
    corners_ = kind.nodes;
    cells_.clear();
    if (kind_ == Cells::edges) take(mesh.edges);
    if (kind_ == Cells::triangles) take(mesh.triangles);
    if (kind_ == Cells::quads) take(mesh.quads);
    if (rotation_ == Rotation::frame && corners_ < 3) throw ComponentError("an edge has no plane", "rotation=\"nodes\" or \"none\"");
    for (const auto* list : {&young_, &poisson_})
      if (list->size() != 1 && list->size() != cells_.size() && (list->empty() || !first_for_others_))
        throw ComponentError(fmt::format("{} has {} values", list == &young_ ? "youngModulus" : "poissonRatio", list->size()),
                             fmt::format("1, or {} (one per cell)", cells_.size()));
  }

  ForceTraits traits() const override {
    ForceTraits traits;
    const bool is_fixed = rotation_ == Rotation::none;
    traits.linear = traits.constant_stiffness = traits.conservative = traits.exact_tangent = is_fixed;
    traits.symmetric = traits.forces_balance = traits.has_rest_shape = true;
    return traits;
  }

  void compile() override {
    std::vector<Group> rows = cells_;
    for (Group& group : rows)
      for (Index& row : group) row += state().firstRow();
    setGroups(std::move(rows), false);
    matrices_.assign(cells_.size(), {});
    for (std::size_t e = 0; e < cells_.size(); ++e) {
      integrate(e);
      turnTangent(e, Mat3::Identity());
    }
  }

  double energy(ConstRows x) const override {
    double sum = 0;
    for (std::size_t e = 0; e < cells_.size(); ++e) {
      const Corners u = displacementOf(e, rotationOf(e, x), x);
      for (int i = 0; i < corners_; ++i)
        for (int j = 0; j < corners_; ++j) sum += u[std::size_t(i)].dot(matrices_[e].block(i, j) * u[std::size_t(j)]) / 2;
    }
    return sum;
  }

  void addForce(ConstRows x, ConstRows, Rows f) override {
    for (std::size_t e = 0; e < cells_.size(); ++e) {
      const Mat3 turn = rotationOf(e, x);
      const Corners u = displacementOf(e, turn, x);
      for (int i = 0; i < corners_; ++i) {
        Vec3 sum = Vec3::Zero();
        for (int j = 0; j < corners_; ++j) sum += matrices_[e].block(i, j) * u[std::size_t(j)];
        f[rows_[e][std::size_t(i)]] -= turn * sum;
      }
      if (rotation_ != Rotation::none) turnTangent(e, turn);
    }
  }

 private:
  enum class Cells { triangles, quads, edges };
  enum class Rotation { none, nodes, frame };
  using Corners = std::array<Vec3, most_corners>;

  template <class List>
  void take(const List& cells) {
    for (const auto& cell : cells) {
      Group group;
      group.fill(Index(cell[0]));
      std::copy(cell.begin(), cell.end(), group.begin());
      cells_.push_back(group);
    }
  }

  static double valueOf(const std::vector<double>& list, std::size_t e) { return e < list.size() ? list[e] : list[0]; }
  const Vec3& restOf(std::size_t e, int corner) const { return state().rest_position[std::size_t(cells_[e][std::size_t(corner)])]; }
  Vec3 placeOf(std::size_t e, int corner, ConstRows x) const { return x[rows_[e][std::size_t(corner)]]; }

  /// K at rest.
  void integrate(std::size_t e) {
    const double young = valueOf(young_, e), nu = valueOf(poisson_, e), mu = young / (2 * (1 + nu));
    const double lambda = young * nu / ((1 + nu) * (plane_stress_ ? 1 - nu : 1 - 2 * nu));
    static const double out = std::sqrt(2. / 3), in = 1 / std::sqrt(6.), side = 1 / std::sqrt(2.);
    std::vector<std::pair<LocalPoint, double>> points{{{0, 0, 0}, 2}};
    if (corners_ == 3) points = {{{1. / 3, 1. / 3, 0}, 0.5}};
    if (corners_ == 4) points = {{{out, 0, 0}, 4. / 3}, {{-in, -side, 0}, 4. / 3}, {{-in, side, 0}, 4. / 3}};
    const CellKind& kind = corners_ == 2 ? cell_kinds::edge : corners_ == 3 ? cell_kinds::triangle : cell_kinds::quad;
    const double section = std::pow(thickness_, 3 - kind.dimension);
    for (const auto& [point, weight] : points) {
      std::array<LocalPoint, most_corners> slopes{};
      kind.gradients(point, slopes.data());
      Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(3, kind.dimension);
      for (int a = 0; a < corners_; ++a)
        for (int d = 0; d < kind.dimension; ++d) jacobian.col(d) += restOf(e, a) * slopes[std::size_t(a)][std::size_t(d)];
      const Eigen::MatrixXd metric = jacobian.transpose() * jacobian;
      const double size = std::sqrt(metric.determinant());
      if (!(size > 0))
        throw ComponentError(fmt::format("{} {} has no size at rest", kind.singular, e), "cells whose corners are apart");
      const Eigen::MatrixXd back = jacobian * metric.inverse();
      Corners g;
      for (int a = 0; a < corners_; ++a) {
        g[std::size_t(a)].setZero();
        for (int d = 0; d < kind.dimension; ++d) g[std::size_t(a)] += back.col(d) * slopes[std::size_t(a)][std::size_t(d)];
      }
      for (int a = 0; a < corners_; ++a)
        for (int b = 0; b < corners_; ++b) {
          const Vec3 &ga = g[std::size_t(a)], &gb = g[std::size_t(b)];
          matrices_[e].block(a, b) += weight * section * size * (lambda * ga * gb.transpose() + mu * gb * ga.transpose() +
                                                       mu * ga.dot(gb) * Mat3::Identity());
        }
    }
  }

  Vec3 centreOf(std::size_t e) const {
    Vec3 sum = Vec3::Zero();
    for (int a = 0; a < corners_; ++a) sum += restOf(e, a);
    return sum / corners_;
  }
  Vec3 centreOf(std::size_t e, ConstRows x) const {
    Vec3 sum = Vec3::Zero();
    for (int a = 0; a < corners_; ++a) sum += placeOf(e, a, x);
    return sum / corners_;
  }

  /// Columns: along the first edge, across it in the plane of three corners, and across that.
  static Mat3 frameOf(const Vec3& a, const Vec3& b, const Vec3& c) {
    const Vec3 first = (b - a).normalized(), normal = first.cross(c - a).normalized();
    Mat3 frame;
    frame << first, normal.cross(first), normal;
    return frame;
  }

  Mat3 rotationOf(std::size_t e, ConstRows x) const {
    if (rotation_ == Rotation::none) return Mat3::Identity();
    if (rotation_ == Rotation::frame)
      return frameOf(placeOf(e, 0, x), placeOf(e, 1, x), placeOf(e, 2, x)) *
             frameOf(restOf(e, 0), restOf(e, 1), restOf(e, 2)).transpose();
    const Vec3 now = centreOf(e, x), then = centreOf(e);
    Mat3 sum = Mat3::Zero();
    for (int a = 0; a < corners_; ++a) sum += (placeOf(e, a, x) - now) * (restOf(e, a) - then).transpose();
    const auto column = [&](int k) { return V3<double>{sum(0, k), sum(1, k), sum(2, k)}; };
    const M3<double> best = local_frame::bestRotation(M3<double>{column(0), column(1), column(2)});
    Mat3 turn;
    turn << best.c0.x, best.c1.x, best.c2.x, best.c0.y, best.c1.y, best.c2.y, best.c0.z, best.c1.z, best.c2.z;
    return turn;
  }

  Corners displacementOf(std::size_t e, const Mat3& turn, ConstRows x) const {
    const bool turns = rotation_ != Rotation::none;
    const Vec3 now = turns ? centreOf(e, x) : Vec3(Vec3::Zero()), then = turns ? centreOf(e) : Vec3(Vec3::Zero());
    Corners u;
    for (int a = 0; a < corners_; ++a) u[std::size_t(a)] = turn.transpose() * (placeOf(e, a, x) - now) - (restOf(e, a) - then);
    return u;
  }

  void turnTangent(std::size_t e, const Mat3& turn) {
    stiffness_[e].corners = corners_;
    for (int i = 0; i < corners_; ++i)
      for (int j = 0; j < corners_; ++j) stiffness_[e].block(i, j) = -(turn * matrices_[e].block(i, j) * turn.transpose());
  }

  TopologyLink topology_;
  Cells kind_ = Cells::triangles;
  Rotation rotation_ = Rotation::none;
  std::vector<double> young_{1000}, poisson_{0.3};
  double thickness_ = 1;
  bool plane_stress_ = false, first_for_others_ = false;
  int corners_ = 3;
  std::vector<Group> cells_;
  struct CellMatrix {
    CellMatrix() { blocks.fill(Mat3::Zero()); }
    std::array<Mat3, std::size_t(most_corners) * most_corners> blocks;
    const Mat3& block(int i, int j) const { return blocks[std::size_t(i * most_corners + j)]; }
    Mat3& block(int i, int j) { return blocks[std::size_t(i * most_corners + j)]; }
  };
  std::vector<CellMatrix> matrices_;  ///< K [N/m], shape (cells)
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(thin_cells_fem_force_field) {
  factory.add<stroma::ThinCells>("ThinCellsFEMForceField", "edges, triangles or quads that resist as parts of a body of one thickness");
}
