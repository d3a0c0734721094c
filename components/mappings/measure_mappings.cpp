// SPDX-License-Identifier: LGPL-2.1-or-later
// Numbers that measure cells or nodes, for springs, limits or constraints on them. The child has one number for each
// (template Vec1).
//
//   AreaMapping             y = |(b - a) x (c - a)| / 2           of each triangle of a mesh
//   VolumeMapping           y = (b - a).((c - a) x (d - a)) / 6   of each tetrahedron, negative where it is inverted
//   SquareMapping           y = x^2                               of each number of the state that is followed
//   DistanceToPlaneMapping  y = n.(x - planePoint)                of each node, n = planeNormal / |planeNormal|
//
// A force f on a number acts on the nodes by the slope of y. Its derivative is the geometric stiffness f d2y/dx2: with e_i the
// side of a triangle against its corner i, n the unit normal and N = 2 A,
//
//   dA/dx_i = n x e_i / 2,   d2A/dx_i dx_j = 1/2 ( [e_i]^T (I - n n^T) [e_j] / N + s_ij [n] ),   s_ij = -1 for j after i, 1 before
//   dV/db = (c - a) x (d - a) / 6 and so on,   d2V/db dc = -[d - a] / 6 and so on
//
// geometricStiffness: None leaves it out, Exact has all of it, Stabilized (the default) only that of f < 0. That of a square is
// never stabilized, as in SOFA. A flat triangle without area has no slope.
//
// Source: names, attributes and signs are SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-10"/>
//   <MeshTopology name="net" position="0 0 0  1 0 0  0 1 0  0 0 1" triangles="0 1 2" tetrahedra="0 1 2 3"/>
//   <MechanicalObject name="points"/>
//   <UniformMass totalMass="0.4"/>
//   <FixedProjectiveConstraint indices="0"/>
//   <Node name="areas">
//     <MechanicalObject name="area" template="Vec1"/>
//     <AreaMapping topology="@../net" applyRestPosition="true"/>
//     <RestShapeSpringsForceField stiffness="1000"/>
//   </Node>
//   <Node name="volumes">
//     <MechanicalObject name="volume" template="Vec1"/>
//     <VolumeMapping topology="@../net" applyRestPosition="true"/>
//     <RestShapeSpringsForceField stiffness="1000"/>
//     <Node name="squares">
//       <MechanicalObject name="square" template="Vec1"/>
//       <SquareMapping/>
//     </Node>
//   </Node>
//   <Node name="heights">
//     <MechanicalObject name="height" template="Vec1"/>
//     <DistanceToPlaneMapping planeNormal="0 1 0" planePoint="0 -1 0"/>
//     <RestShapeSpringsForceField stiffness="10"/>
//   </Node>
// </Node>
#include <Eigen/Geometry>
#include <cmath>

#include "components/mappings/linked_mapping.h"
#include "components/mappings/numbers_of_cells.h"
#include "framework/mechanics/frames.h"
#include "framework/mechanics/node_indices.h"
#include "framework/mesh/simplex_size.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

/// A number of each of several groups of rows. `Measure` has how many rows a group has, the number, its slope dy/dx_i and its
/// second derivative d2y/dx_i dx_j.
template <class Measure>
class MeasureMapping : public CurvedMapping {
 public:
  static constexpr std::size_t n = Measure::corners;
  using Corners = std::array<Vec3, n>;
  void declare(DataTable& table) override {
    CurvedMapping::declare(table);
    declareGeometricStiffness(table, geometric_, true);
    table.add("applyRestPosition", at_rest_).help("numbers at rest are those of the shape at rest, else the child's own or zero");
  }

  void apply(Rows x) const override {
    const Index first = output().firstRow();
    places_.resize(groups_.size());
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      for (std::size_t i = 0; i < n; ++i) places_[g][i] = x[row(g, i)];
      x[first + Index(g)] = Vec3(Measure::value(places_[g]), 0, 0);
    }
  }
  void applyJ(Rows v) const override {
    const Index first = output().firstRow();
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      double sum = 0;
      for (std::size_t i = 0; i < n; ++i) sum += Measure::slope(places_[g], i).dot(Vec3(v[row(g, i)]));
      v[first + Index(g)] = Vec3(sum, 0, 0);
    }
  }
  void applyJT(Rows f) const override {
    const Index first = output().firstRow();
    for (std::size_t g = 0; g < groups_.size(); ++g)
      for (std::size_t i = 0; i < n; ++i) f[row(g, i)] += f[first + Index(g)][0] * Measure::slope(places_[g], i);
  }
  void addJacobian(std::vector<JacobianBlock>& out) const override {
    for (std::size_t g = 0; g < groups_.size(); ++g)
      for (std::size_t i = 0; i < n; ++i)
        out.push_back({output().firstRow() + Index(g), row(g, i), Vec3::UnitX() * Measure::slope(places_[g], i).transpose()});
  }
  void addCurvature(ConstRows v, Rows a) const override {
    if (!this->convects()) return;
    for (std::size_t g = 0; g < groups_.size(); ++g)
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j)
          a[output().firstRow() + Index(g)][0] += Vec3(v[row(g, i)]).dot(Measure::bend(places_[g], i, j) * Vec3(v[row(g, j)]));
  }

 protected:
  using Group = std::array<Index, n>;  ///< rows of input()

  /// At the end of init().
  void setGroups(std::vector<Group> groups, const char* of_what) {
    groups_ = std::move(groups);
    State& child = output();
    makeNumbers(child, groups_.size(), of_what);
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      Corners now, rest;
      for (std::size_t i = 0; i < n; ++i) {
        now[i] = input().position[std::size_t(groups_[g][i])];
        rest[i] = input().rest_position[std::size_t(groups_[g][i])];
      }
      child.position[g][0] = Measure::value(now);
      if (at_rest_) child.rest_position[g][0] = Measure::value(rest);
    }
  }

  void geometricBlocks(ConstRows f, std::vector<Block>& out) const override {
    if (geometric_ == GeometricStiffness::none) return;
    const bool only_pulls = geometric_ == GeometricStiffness::stabilized && !Measure::is_never_stabilized;
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      const double force = f.count > 0 ? f[output().firstRow() + Index(g)][0] : 0;
      const bool counts = force != 0 && !(only_pulls && force > 0);
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j)
          out.push_back({row(g, i), row(g, j), counts ? Mat3(force * Measure::bend(places_[g], i, j)) : Mat3(Mat3::Zero())});
    }
  }

 private:
  Index row(std::size_t g, std::size_t i) const { return input().firstRow() + groups_[g][i]; }

  GeometricStiffness geometric_ = GeometricStiffness::stabilized;
  bool at_rest_ = false;
  std::vector<Group> groups_;
  mutable std::vector<Corners> places_;  ///< at the last apply()
};

/// Of the cells of a mesh.
template <class Measure>
class CellMapping final : public MeasureMapping<Measure> {
 public:
  void declare(DataTable& table) override {
    MeasureMapping<Measure>::declare(table);
    table.addLink("topology", topology_).help("mesh of the cells; that of this node or the nearest above by default");
  }
  void init() override {
    MeasureMapping<Measure>::init();
    const Index rows = this->input().rows_per_node;
    auto groups = cellsOfMesh(*this, topology_, Measure::cells, Measure::what, this->input().nodes());
    for (auto& group : groups)
      for (Index& node : group) node *= rows;
    this->setGroups(std::move(groups), Measure::what);
  }

 private:
  Link<Topology> topology_{"topology"};
};

struct Area {
  static constexpr std::size_t corners = 3;
  static constexpr auto cells = &Mesh::triangles;
  static constexpr const char* what = "triangles";
  static constexpr bool is_never_stabilized = false;
  using Corners = std::array<Vec3, corners>;
  static Vec3 normal(const Corners& p) { return (p[1] - p[0]).cross(p[2] - p[0]); }
  static Vec3 side(const Corners& p, std::size_t i) { return p[(i + 2) % 3] - p[(i + 1) % 3]; }
  static double value(const Corners& p) { return normal(p).norm() / 2; }
  static Vec3 slope(const Corners& p, std::size_t i) {
    const Vec3 N = normal(p);
    return N.norm() > 0 ? Vec3(N.normalized().cross(side(p, i)) / 2) : Vec3(Vec3::Zero());
  }
  static Mat3 bend(const Corners& p, std::size_t i, std::size_t j) {
    const Vec3 N = normal(p);
    const double size = N.norm();
    if (!(size > 0)) return Mat3::Zero();
    const Vec3 unit = N / size;
    const double sign = i == j ? 0 : j == (i + 1) % 3 ? -1 : 1;
    const Mat3 across = Mat3::Identity() - unit * unit.transpose();
    return (crossMatrix(side(p, i)).transpose() * across * crossMatrix(side(p, j)) / size + sign * crossMatrix(unit)) / 2;
  }
};

struct Volume {
  static constexpr std::size_t corners = 4;
  static constexpr auto cells = &Mesh::tetrahedra;
  static constexpr const char* what = "tetrahedra";
  static constexpr bool is_never_stabilized = false;
  using Corners = std::array<Vec3, corners>;
  static double value(const Corners& p) { return tetrahedronVolume(p[0], p[1], p[2], p[3]); }
  static Vec3 slope(const Corners& p, std::size_t i) {
    if (i == 0) return -(slope(p, 1) + slope(p, 2) + slope(p, 3));
    const std::size_t j = i % 3 + 1, k = j % 3 + 1;
    return (p[j] - p[0]).cross(p[k] - p[0]) / 6;
  }
  static Mat3 bend(const Corners& p, std::size_t i, std::size_t j) {
    if (i == j) return Mat3::Zero();
    if (i == 0) return -(bend(p, 1, j) + bend(p, 2, j) + bend(p, 3, j));
    if (j == 0) return bend(p, 0, i).transpose();
    const Mat3 turned = crossMatrix(p[6 - i - j] - p[0]) / 6;
    return j == i % 3 + 1 ? Mat3(-turned) : turned;
  }
};

struct Square {
  static constexpr std::size_t corners = 1;
  static constexpr bool is_never_stabilized = true;
  using Corners = std::array<Vec3, corners>;
  static double value(const Corners& p) { return p[0][0] * p[0][0]; }
  static Vec3 slope(const Corners& p, std::size_t) { return Vec3(2 * p[0][0], 0, 0); }
  static Mat3 bend(const Corners&, std::size_t, std::size_t) { return 2 * Vec3::UnitX() * Vec3::UnitX().transpose(); }
};

class SquareMapping final : public MeasureMapping<Square> {
 public:
  void init() override {
    MeasureMapping::init();
    if (input().rows_per_node != 1 || input().kindOf(0) != RowKind::value)
      throw ComponentError(fmt::format("{} holds no numbers", input().path()), "a state of numbers (template=\"Vec1\")");
    std::vector<Group> groups;
    for (Index i = 0; i < input().size(); ++i) groups.push_back({i});
    setGroups(std::move(groups), "numbers");
  }
};

class DistanceToPlaneMapping final : public LinkedMapping {
 public:
  void declare(DataTable& table) override {
    LinkedMapping::declare(table);
    table.add("planeNormal", normal_).help("of the plane; any length").unit("-").required();
    table.add("planePoint", point_).help("a point of the plane").unit("m");
    table.add("applyRestPosition", at_rest_).help("numbers at rest are those of the shape at rest, else the child's own or zero");
  }
  void init() override {
    LinkedMapping::init();
    if (!(normal_.norm() > 0)) throw ComponentError("planeNormal is zero", "a vector that is not");
    unit_ = normal_.normalized();
    if (input().kindOf(0) != RowKind::place)
      throw ComponentError(fmt::format("the nodes of {} have no places", input().path()), "points or frames");
    nodes_ = allNodes(input());
    makeNumbers(output(), nodes_.size(), "nodes");
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      output().position[i][0] = height(input().position[std::size_t(nodes_[i])]);
      if (at_rest_) output().rest_position[i][0] = height(input().rest_position[std::size_t(nodes_[i])]);
    }
  }
  bool isLinear() const override { return true; }
  void apply(Rows x) const override {
    for (std::size_t i = 0; i < nodes_.size(); ++i) x[own(i)] = Vec3(height(x[followed(i)]), 0, 0);
  }
  void applyJ(Rows v) const override {
    for (std::size_t i = 0; i < nodes_.size(); ++i) v[own(i)] = Vec3(unit_.dot(Vec3(v[followed(i)])), 0, 0);
  }
  void applyJT(Rows f) const override {
    for (std::size_t i = 0; i < nodes_.size(); ++i) f[followed(i)] += f[own(i)][0] * unit_;
  }
  void addJacobian(std::vector<JacobianBlock>& out) const override {
    for (std::size_t i = 0; i < nodes_.size(); ++i) out.push_back({own(i), followed(i), Vec3::UnitX() * unit_.transpose()});
  }
  void addCurvature(ConstRows, Rows) const override {}
  void addGeometricProduct(ConstRows, ConstRows, double, Rows) const override {}
  void addGeometricPattern(BlockPattern&) const override {}
  void addGeometricStiffness(ConstRows, double, BlockMatrix&) const override {}

 private:
  double height(const Vec3& p) const { return unit_.dot(p - point_); }
  Index own(std::size_t i) const { return output().firstRow() + Index(i); }
  Index followed(std::size_t i) const { return input().firstRow() + nodes_[i]; }

  Vec3 normal_ = Vec3::UnitX(), unit_ = Vec3::UnitX(), point_ = Vec3::Zero();
  bool at_rest_ = false;
  std::vector<Index> nodes_;  ///< the first row of each
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(measure_mappings) {
  factory.add<stroma::CellMapping<stroma::Area>>("AreaMapping", "numbers that are the areas of triangles");
  factory.add<stroma::CellMapping<stroma::Volume>>("VolumeMapping", "numbers that are the volumes of tetrahedra");
  factory.add<stroma::SquareMapping>("SquareMapping", "numbers that are the squares of others");
  factory.add<stroma::DistanceToPlaneMapping>("DistanceToPlaneMapping", "numbers that are distances of nodes from a plane");
}
