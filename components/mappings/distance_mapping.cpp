// SPDX-License-Identifier: LGPL-2.1-or-later
// DistanceMapping and similar mappings: numbers that are distances between pairs of points.
//
//   DistanceMapping        y_e = |x_b - x_a| - L_e        for each edge of a mesh
//   SquareDistanceMapping  y_e = |x_b - x_a|^2
//   DistanceMultiMapping   y_e = |x_b - x_a| - L_e        between points of several states
//   DistanceFromTarget     y_i = |x_i - target_i| - L_i
//
// The child has one number for each (template Vec1). L is restLengths, by default the initial distance; with computeDistance
// it is zero. For a frame the centre is used. Forces f on the numbers act along the pairs,
//
//   f_b = -f_a = n f,   n = (x_b - x_a)/d,   geometric stiffness f/d (I - n n^T)
//
// and 2 (x_b - x_a) f and 2 f I for squares. geometricStiffness: None leaves it out, Exact has all of it, Stabilized (the
// default) only that of tensions, f < 0, which is stabilising.
//
// Edges are those of `topology`, else of the mesh of this node or the nearest above that has any. For DistanceMultiMapping
// they join the points of indexPairs, each a state of input and a node there.
//
// Source: names and attributes are SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-10"/>
//   <MechanicalObject name="points" position="0 0 0  1 0 0  2 0 0"/>
//   <UniformMass totalMass="0.3"/>
//   <FixedProjectiveConstraint indices="0"/>
//   <Node name="lengths">
//     <MeshTopology edges="0 1  1 2"/>
//     <MechanicalObject name="stretch" template="Vec1"/>
//     <DistanceMapping/>
//     <RestShapeSpringsForceField stiffness="1000"/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include <cmath>

#include "components/mappings/linked_mapping.h"
#include "components/mappings/numbers_of_cells.h"
#include "framework/mechanics/node_indices.h"
#include "framework/mechanics/state_topology.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

/// Pairs of points, each of one of the inputs; or a point and a place.
class PairMapping : public CurvedMapping {
 public:
  void declare(DataTable& table) override {
    CurvedMapping::declare(table);
    declareGeometricStiffness(table, geometric_, true);
    table.add("applyRestPosition", at_rest_).help("numbers at rest are those of the points at rest, else the child's own or zero");
  }

  void apply(Rows x) const override {
    const Index first = output().firstRow();
    ways_.resize(pairs_.size());
    for (std::size_t e = 0; e < pairs_.size(); ++e) {
      ways_[e] = (pairs_[e].b < 0 ? pairs_[e].target : Vec3(x[row(pairs_[e].state_b, pairs_[e].b)])) -
                 x[row(pairs_[e].state_a, pairs_[e].a)];
      x[first + Index(e)] = Vec3(isSquare() ? ways_[e].squaredNorm() : ways_[e].norm() - pairs_[e].length, 0, 0);
    }
  }
  void applyJ(Rows v) const override {
    const Index first = output().firstRow();
    for (std::size_t e = 0; e < pairs_.size(); ++e) {
      Vec3 relative = -v[row(pairs_[e].state_a, pairs_[e].a)];
      if (pairs_[e].b >= 0) relative += v[row(pairs_[e].state_b, pairs_[e].b)];
      v[first + Index(e)] = Vec3(slope(e).dot(relative), 0, 0);
    }
  }
  void applyJT(Rows f) const override {
    const Index first = output().firstRow();
    for (std::size_t e = 0; e < pairs_.size(); ++e) {
      const Vec3 force = f[first + Index(e)][0] * slope(e);
      f[row(pairs_[e].state_a, pairs_[e].a)] -= force;
      if (pairs_[e].b >= 0) f[row(pairs_[e].state_b, pairs_[e].b)] += force;
    }
  }
  void addJacobian(std::vector<JacobianBlock>& out) const override {
    for (std::size_t e = 0; e < pairs_.size(); ++e) {
      const Index own = output().firstRow() + Index(e);
      const Mat3 block = Vec3::UnitX() * slope(e).transpose();
      out.push_back({own, row(pairs_[e].state_a, pairs_[e].a), -block});
      if (pairs_[e].b >= 0) out.push_back({own, row(pairs_[e].state_b, pairs_[e].b), block});
    }
  }
  /// y'' = n.a + (|u|^2 - (n.u)^2)/d, u the relative velocity; of squares 2 (x_b - x_a).a + 2 |u|^2
  void addCurvature(ConstRows v, Rows a) const override {
    if (!convects()) return;
    const Index first = output().firstRow();
    for (std::size_t e = 0; e < pairs_.size(); ++e) {
      Vec3 relative = -v[row(pairs_[e].state_a, pairs_[e].a)];
      if (pairs_[e].b >= 0) relative += v[row(pairs_[e].state_b, pairs_[e].b)];
      const double square = relative.squaredNorm(), distance = ways_[e].norm(), along = slope(e).dot(relative);
      if (isSquare())
        a[first + Index(e)][0] += 2 * square;
      else if (distance > 0)
        a[first + Index(e)][0] += (square - along * along) / distance;
    }
  }

 protected:
  struct Pair {
    int state_a = 0, state_b = 0;
    Index a = 0, b = -1;  ///< rows of the states; b = -1: the other end is `target`
    Vec3 target = Vec3::Zero();
    double length = 0;  ///< L [m]
  };
  virtual bool isSquare() const { return false; }

  /// At the end of init(): the child gets a number for each pair.
  void setPairs(std::vector<Pair> pairs, const std::vector<double>& lengths, bool whole_distance) {
    pairs_ = std::move(pairs);
    inputs_ = inputs();
    if (!lengths.empty() && lengths.size() != pairs_.size())
      throw ComponentError(fmt::format("restLengths has {} values for {} pairs", lengths.size(), pairs_.size()),
                           "one for each");
    State& child = output();
    makeNumbers(child, pairs_.size(), "pairs");
    for (std::size_t e = 0; e < pairs_.size(); ++e) {
      const double start = wayOf(e, false).norm();
      pairs_[e].length = !lengths.empty() ? lengths[e] : whole_distance || isSquare() ? 0 : start;
      child.position[e][0] = isSquare() ? start * start : start - pairs_[e].length;
      const double rest = wayOf(e, true).norm();
      if (at_rest_) child.rest_position[e][0] = isSquare() ? rest * rest : rest - pairs_[e].length;
    }
  }

  void geometricBlocks(ConstRows f, std::vector<Block>& out) const override {
    if (geometric_ == GeometricStiffness::none) return;
    for (std::size_t e = 0; e < pairs_.size(); ++e) {
      const Index a = row(pairs_[e].state_a, pairs_[e].a);
      const Mat3 k = f.count > 0 ? curvature(e, f[output().firstRow() + Index(e)][0]) : Mat3(Mat3::Zero());
      out.push_back({a, a, k});
      if (pairs_[e].b < 0) continue;
      const Index b = row(pairs_[e].state_b, pairs_[e].b);
      out.push_back({b, b, k}), out.push_back({a, b, -k}), out.push_back({b, a, -k});
    }
  }

 private:
  Index row(int state, Index row) const { return inputs_[std::size_t(state)]->firstRow() + row; }
  /// dy/dx_b
  Vec3 slope(std::size_t e) const {
    if (isSquare()) return 2 * ways_[e];
    const double distance = ways_[e].norm();
    return distance > 0 ? Vec3(ways_[e] / distance) : Vec3(Vec3::Zero());
  }
  Mat3 curvature(std::size_t e, double force) const {
    if (geometric_ == GeometricStiffness::stabilized && force > 0) return Mat3::Zero();
    if (isSquare()) return 2 * force * Mat3::Identity();
    const double distance = ways_[e].norm();
    if (!(distance > 0)) return Mat3::Zero();
    const Vec3 n = ways_[e] / distance;
    return force / distance * (Mat3::Identity() - n * n.transpose());
  }
  Vec3 wayOf(std::size_t e, bool rest) const {
    const auto place = [&](int state, Index row) {
      const State& of = *inputs_[std::size_t(state)];
      return (rest ? of.rest_position : of.position)[std::size_t(row)];
    };
    return (pairs_[e].b < 0 ? pairs_[e].target : place(pairs_[e].state_b, pairs_[e].b)) -
           place(pairs_[e].state_a, pairs_[e].a);
  }

  GeometricStiffness geometric_ = GeometricStiffness::stabilized;
  bool at_rest_ = false;
  std::vector<State*> inputs_;
  std::vector<Pair> pairs_;
  mutable std::vector<Vec3> ways_;  ///< x_b - x_a at the last apply()
};

/// By the edges of a mesh.
class EdgeMapping : public PairMapping {
 public:
  void declare(DataTable& table) override {
    PairMapping::declare(table);
    table.addLink("topology", topology_)
        .help("mesh whose edges are the pairs; that of this node or the nearest above by default");
  }

 protected:
  const std::vector<Edge>& edges(Index nodes) const { return cellsOfMesh(*this, topology_, &Mesh::edges, "edges", nodes); }
  /// Of points of the one input.
  std::vector<Pair> edgePairs() const {
    std::vector<Pair> pairs;
    const Index rows = input().rows_per_node;
    for (const Edge& edge : edges(input().nodes())) pairs.push_back({0, 0, edge[0] * rows, edge[1] * rows});
    return pairs;
  }
  Link<Topology> topology_{"topology"};
};

class DistanceMapping : public EdgeMapping {
 public:
  void declare(DataTable& table) override {
    EdgeMapping::declare(table);
    table.add("restLengths", lengths_).unit("m").help("L of each pair; the distances at the start by default");
    table.add("computeDistance", whole_).help("L is zero: the numbers are the distances");
    for (const char* name : {"showObjectScale", "showColor"}) table.addVisualOnly(name);
  }
  void init() override {
    EdgeMapping::init();
    setPairs(edgePairs(), lengths_, whole_);
  }

 protected:
  std::vector<double> lengths_;
  bool whole_ = false;
};

class SquareDistanceMapping final : public EdgeMapping {
 public:
  void init() override {
    EdgeMapping::init();
    setPairs(edgePairs(), {}, false);
  }

 protected:
  bool isSquare() const override { return true; }
};

class DistanceMultiMapping final : public DistanceMapping {
 public:
  void declare(DataTable& table) override {
    DistanceMapping::declare(table);
    table.add("indexPairs", points_)
        .help("for each point of the edges the number of its state in input, and its node there")
        .required();
  }
  void init() override {
    EdgeMapping::init();
    if (points_.size() % 2 != 0)
      throw ComponentError(fmt::format("indexPairs has {} numbers", points_.size()), "two for each point");
    const auto end = [&](Index point) {
      const int state = points_[std::size_t(2 * point)];
      if (state < 0 || std::size_t(state) >= inputs().size())
        throw ComponentError(fmt::format("indexPairs names state {} of {}", state, inputs().size()),
                             fmt::format("0 to {}", inputs().size() - 1));
      const State& from = *inputs()[std::size_t(state)];
      checkNode(points_[std::size_t(2 * point + 1)], std::size_t(2 * point + 1), from, "indexPairs");
      return std::pair(state, points_[std::size_t(2 * point + 1)] * from.rows_per_node);
    };
    std::vector<Pair> pairs;
    for (const Edge& edge : edges(Index(points_.size() / 2))) {
      const auto [state_a, a] = end(edge[0]);
      const auto [state_b, b] = end(edge[1]);
      pairs.push_back({state_a, state_b, a, b});
    }
    setPairs(std::move(pairs), lengths_, whole_);
  }

 protected:
  bool takesManyInputs() const override { return true; }

 private:
  std::vector<int> points_;
};

class DistanceFromTarget final : public PairMapping {
 public:
  void declare(DataTable& table) override {
    PairMapping::declare(table);
    table.add("indices", indices_).help("points whose distances are meant").required();
    table.add("targetPositions", targets_).unit("m").help("from where, one for each").required();
    table.add("restLengths", lengths_).unit("m").help("L of each; the distances at the start by default");
    for (const char* name : {"showObjectScale", "showColor"}) table.addVisualOnly(name);
  }
  void init() override {
    PairMapping::init();
    const std::vector<Index> rows = checkedNodesInOrder(indices_, input(), "indices");
    if (rows.size() != targets_.size())
      throw ComponentError(fmt::format("targetPositions has {} places for {} points", targets_.size(), rows.size()),
                           "one for each");
    std::vector<Pair> pairs;
    for (std::size_t i = 0; i < rows.size(); ++i) pairs.push_back({0, 0, rows[i], -1, targets_[i]});
    setPairs(std::move(pairs), lengths_, false);
  }

 private:
  std::vector<int> indices_;
  std::vector<Vec3> targets_;
  std::vector<double> lengths_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(distance_mapping) {
  factory.add<stroma::DistanceMapping>("DistanceMapping", "numbers that are the lengths of pairs of points");
  factory.add<stroma::SquareDistanceMapping>("SquareDistanceMapping", "numbers that are the squares of lengths");
  factory.add<stroma::DistanceMultiMapping>("DistanceMultiMapping", "lengths between points of several states");
  factory.add<stroma::DistanceFromTarget>("DistanceFromTarget", "numbers that are distances of points from places");
}
