// SPDX-License-Identifier: LGPL-2.1-or-later
// Mesh2PointTopologicalMapping creates points on the cells of a mesh. SubsetTopologicalMapping finds the nodes and cells of one mesh in
// another.
//
// Mesh2PointTopologicalMapping: for each node, edge, triangle, quad, tetrahedron and hexahedron of the input, in this order, the points
//   given by pointBaryCoords, edgeBaryCoords ..., three numbers each:
//     node: x + (u, v, w)     edge: (1 - u) a + u b     triangle: (1 - u - v) a + u b + v c
//     quad, hexahedron: bilinear, trilinear in u, v, w from 0 to 1     tetrahedron: (1 - u - v - w) a + u b + v c + w d
//   If the input lists no edges, they are those of its solid cells, or of its faces if there are none, cell by cell. copyEdges,
//   copyTriangles and copyTetrahedra also copy these cells, between the first points of their nodes. splitTetrahedra cuts each tetrahedron
//   into eight, between the points of its nodes and of the middles of its edges.
//   Mesh2PointMechanicalMapping maps a state in the same way.
//
// SubsetTopologicalMapping: pointD2S is, for each node of `output`, the node of `input` at the same place (samePoints: with the same
//   number). pointS2D is the inverse, with -1 for none. handleEdges and similar attributes do the same for cells. SubsetMapping
//   indices="@mapping.pointD2S" then maps the state.
//
// Source: names and attributes are SOFA's. Its quads swap corners 2 and 3. In SOFA the lists of SubsetTopologicalMapping also follow
// changes of the mesh.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="100" tolerance="1e-10"/>
//   <MeshTopology name="cells" position="0 0 0  1 0 0  0 1 0  0 0 1" tetrahedra="0 1 2 3"/>
//   <MechanicalObject/>
//   <UniformMass totalMass="1"/>
//   <TetrahedronFEMForceField youngModulus="1000" poissonRatio="0.3"/>
//   <FixedProjectiveConstraint indices="0"/>
//   <Node name="points">
//     <PointSetTopologyContainer name="cloud"/>
//     <Mesh2PointTopologicalMapping input="@../cells" output="@cloud" pointBaryCoords="0 0 0" tetraBaryCoords="0.25 0.25 0.25"/>
//     <MechanicalObject/>
//     <Mesh2PointMechanicalMapping/>
//     <ConstantForceField totalForce="1 0 0"/>
//   </Node>
//   <Node name="part">
//     <TriangleSetTopologyContainer name="face" position="1 0 0  0 1 0  0 0 1" triangles="0 1 2"/>
//     <SubsetTopologicalMapping name="which" input="@../cells" output="@face"/>
//     <MechanicalObject/>
//     <SubsetMapping indices="@which.pointD2S"/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "framework/mesh/cell_lists.h"
#include "framework/mesh/topology.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

using Sides = std::vector<std::array<std::size_t, 2>>;
const Sides sides_of_triangles{{1, 2}, {2, 0}, {0, 1}}, sides_of_quads{{1, 2}, {2, 3}, {3, 0}, {0, 1}},
    sides_of_tetrahedra{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}},
    sides_of_hexahedra{{0, 1}, {0, 3}, {0, 4}, {1, 2}, {1, 5}, {2, 3}, {2, 6}, {3, 7}, {4, 5}, {4, 7}, {5, 6}, {6, 7}};

/// Those that it lists, else those of its solid cells, or of its faces where there are none, one cell after the other.
std::vector<Edge> edgesOf(const Mesh& mesh) {
  std::vector<Edge> edges = mesh.edges;
  if (!edges.empty()) return edges;
  std::set<Edge> known;
  const auto add = [&](Index one, Index other) {
    const Edge edge{std::min(one, other), std::max(one, other)};
    if (known.insert(edge).second) edges.push_back(edge);
  };
  const auto addAll = [&](const auto& cells, const Sides& sides) {
    for (const auto& cell : cells)
      for (const auto& side : sides) add(cell[side[0]], cell[side[1]]);
  };
  addAll(mesh.tetrahedra, sides_of_tetrahedra), addAll(mesh.hexahedra, sides_of_hexahedra);
  if (edges.empty()) addAll(mesh.triangles, sides_of_triangles), addAll(mesh.quads, sides_of_quads);
  for (const Edge& edge : mesh.allEdges()) add(edge[0], edge[1]);  // of other kinds of cells
  return edges;
}

class Mesh2Point final : public TopologicalMapping {
 public:
  void declare(DataTable& table) override {
    table.addLink("input", input_).help("topology whose parts are taken").required();
    table.addLink("output", output_).help("container to fill; without it the mapping is a topology itself");
    table.add("pointBaryCoords", of_points_).help("offsets of the points of each node").unit("m");
    table.add("edgeBaryCoords", of_edges_).help("places of the points of each edge").unit("-");
    table.add("triangleBaryCoords", of_triangles_).help("places of the points of each triangle").unit("-");
    table.add("quadBaryCoords", of_quads_).help("places of the points of each quad").unit("-");
    table.add("tetraBaryCoords", of_tetrahedra_).help("places of the points of each tetrahedron").unit("-");
    table.add("hexaBaryCoords", of_hexahedra_).help("places of the points of each hexahedron").unit("-");
    table.add("copyEdges", copies_edges_).help("the edges of the input too");
    table.add("copyTriangles", copies_triangles_).help("the triangles of the input too");
    table.add("copyTetrahedra", copies_tetrahedra_).help("the tetrahedra of the input too");
    table.add("splitTetrahedra", splits_)
        .help("eight for each tetrahedron, with pointBaryCoords 0 0 0 and edgeBaryCoords 0.5 0 0; edges as tetrahedra name them");
    table.add("position", mesh_.position).alias("points").help("the points").unit("m").output();
    table.add("edges", mesh_.edges).help("copied edges").output();
    table.add("triangles", mesh_.triangles).help("copied triangles").output();
    table.add("pointNodes", nodes_).help("nodes of the input that each point is a sum of, one point after the other").output();
    table.add("pointWeights", weights_).help("their weights").unit("-").output();
    table.add("pointEnds", ends_).help("of each point one past its last node in pointNodes").output();
    table.add("pointOffsets", offsets_).help("what is added to the sum of each point").unit("m").output();
  }

  void init() override {
    const Topology* source = input_.get();
    if (!source) throw ComponentError("there is no topology to take parts of", "input=\"@...\"");
    const Mesh& from = source->mesh();
    mesh_ = Mesh();
    nodes_.clear();
    ends_.clear();
    weights_.clear();
    offsets_.clear();
    for (Index i = 0; i < from.nodes(); ++i)
      for (const Vec3& offset : of_points_) addPoint(std::array<Index, 1>{i}, {1}, offset);
    const auto addAll = [this](const auto& cells, const std::vector<Vec3>& places, auto&& weights) {
      for (const auto& cell : cells)
        for (const Vec3& p : places) addPoint(cell, weights(p[0], p[1], p[2]), Vec3::Zero());
    };
    using Weights = std::vector<double>;
    const std::vector<Edge> edges = of_edges_.empty() && !splits_ ? std::vector<Edge>() : edgesOf(from);
    if (!of_edges_.empty()) addAll(edges, of_edges_, [](double u, double, double) { return Weights{1 - u, u}; });
    addAll(from.triangles, of_triangles_, [](double u, double v, double) { return Weights{1 - u - v, u, v}; });
    addAll(from.quads, of_quads_, [](double u, double v, double) { return bilinear(u, v, 1); });
    addAll(from.tetrahedra, of_tetrahedra_, [](double u, double v, double w) { return Weights{1 - u - v - w, u, v, w}; });
    addAll(from.hexahedra, of_hexahedra_, [](double u, double v, double w) {
      Weights near = bilinear(u, v, 1 - w);
      const Weights far = bilinear(u, v, w);
      near.insert(near.end(), far.begin(), far.end());
      return near;
    });
    if (ends_.empty())
      throw ComponentError("no part of the input gives a point", "pointBaryCoords, edgeBaryCoords ... of parts that the input has");
    for (std::size_t i = 0, k = 0; i < ends_.size(); ++i) {
      Vec3 place = offsets_[i];
      for (; k < std::size_t(ends_[i]); ++k) place += weights_[k] * from.position[std::size_t(nodes_[k])];
      mesh_.position.push_back(place);
    }
    if (copies_edges_) copy(edgesOf(from), mesh_.edges, "copyEdges");
    if (copies_triangles_) copy(from.triangles, mesh_.triangles, "copyTriangles");
    if (copies_tetrahedra_) copy(from.tetrahedra, mesh_.tetrahedra, "copyTetrahedra");
    if (splits_) split(from, edges);
  }

 private:
  void split(const Mesh& from, const std::vector<Edge>& edges) {
    // corners 0 to 3, and from 4 on the middles of the sides
    static constexpr int parts[8][4] = {{0, 4, 5, 6}, {1, 4, 8, 7}, {2, 5, 7, 9}, {3, 6, 9, 8},
                                        {5, 4, 7, 9}, {5, 4, 9, 6}, {8, 4, 9, 7}, {8, 4, 6, 9}};
    if (of_points_.size() != 1 || of_edges_.size() != 1 || of_edges_[0].x() != 0.5)
      throw ComponentError("splitTetrahedra needs one point of each node and the middle of each edge",
                           "pointBaryCoords=\"0 0 0\" edgeBaryCoords=\"0.5 0 0\"");
    if (copies_tetrahedra_)
      throw ComponentError("copyTetrahedra and splitTetrahedra: the cells would lie in their parts", "one of them");
    std::map<std::pair<Index, Index>, Index> middles;
    for (std::size_t e = 0; e < edges.size(); ++e)
      middles[{std::min(edges[e][0], edges[e][1]), std::max(edges[e][0], edges[e][1])}] = from.nodes() + Index(e);
    for (const Tetrahedron& cell : from.tetrahedra) {
      std::vector<Index> nodes(cell.begin(), cell.end());
      for (const auto& side : sides_of_tetrahedra) {
        const auto [a, b] = std::minmax(cell[side[0]], cell[side[1]]);
        const auto found = middles.find({a, b});
        if (found == middles.end())
          throw ComponentError(fmt::format("the mesh lists edges, and not that between {} and {}", a, b), "all edges, or none");
        nodes.push_back(found->second);
      }
      for (const auto& part : parts) {
        Tetrahedron& made = mesh_.tetrahedra.emplace_back();
        for (std::size_t k = 0; k < 4; ++k) made[k] = nodes[std::size_t(part[k])];
      }
    }
  }
  static std::vector<double> bilinear(double u, double v, double times) {
    return {times * (1 - u) * (1 - v), times * u * (1 - v), times * u * v, times * (1 - u) * v};
  }
  template <class Cell>
  void addPoint(const Cell& cell, const std::vector<double>& weights, const Vec3& offset) {
    nodes_.insert(nodes_.end(), cell.begin(), cell.end());
    weights_.insert(weights_.end(), weights.begin(), weights.end());
    ends_.push_back(int(nodes_.size()));
    offsets_.push_back(offset);
  }
  template <class Cell>
  void copy(const std::vector<Cell>& from, std::vector<Cell>& to, const char* name) const {
    if (of_points_.empty()) throw ComponentError(fmt::format("{} needs a point of each node", name), "pointBaryCoords=\"0 0 0\"");
    to = from;
    for (Cell& cell : to)
      for (Index& node : cell) node *= Index(of_points_.size());
  }

  std::vector<Vec3> of_points_, of_edges_, of_triangles_, of_quads_, of_tetrahedra_, of_hexahedra_;
  bool copies_edges_ = false, copies_triangles_ = false, copies_tetrahedra_ = false, splits_ = false;
  std::vector<int> nodes_, ends_;
  std::vector<double> weights_;
  std::vector<Vec3> offsets_;
};

/// Numbers of the parts of a mesh in another one, both ways; -1: there is none.
struct Numbers {
  std::vector<int> in_source, in_part;
};

class SubsetTopologicalMapping final : public Component {
 public:
  std::string roleText() const override { return "mesh engine"; }
  void declare(DataTable& table) override {
    table.addLink("input", input_).help("the whole mesh").required();
    table.addLink("output", output_).help("the mesh that is a part of it").required();
    table.add("samePoints", same_points_).help("both have the same nodes");
    declareKind(table, "Edges", "edge", edges_);
    declareKind(table, "Triangles", "triangle", triangles_);
    declareKind(table, "Quads", "quad", quads_);
    declareKind(table, "Tetrahedra", "tetrahedron", tetrahedra_);
    declareKind(table, "Hexahedra", "hexahedron", hexahedra_);
    declareNumbers(table, "point", points_);
  }

  void init() override {
    if (!input_.get() || !output_.get()) throw ComponentError("input or output is no topology", "two topologies");
    const Mesh &whole = input_.get()->mesh(), &part = output_.get()->mesh();
    matchNodes(whole, part);
    if (edges_.wanted) match(edgesOf(whole), edgesOf(part), edges_.numbers, "edge");
    if (triangles_.wanted) match(whole.triangles, part.triangles, triangles_.numbers, "triangle");
    if (quads_.wanted) match(whole.quads, part.quads, quads_.numbers, "quad");
    if (tetrahedra_.wanted) match(whole.tetrahedra, part.tetrahedra, tetrahedra_.numbers, "tetrahedron");
    if (hexahedra_.wanted) match(whole.hexahedra, part.hexahedra, hexahedra_.numbers, "hexahedron");
  }

 private:
  struct KindOfCell {
    bool wanted = false;
    Numbers numbers;
  };
  static void declareNumbers(DataTable& table, const std::string& name, Numbers& numbers) {
    table.add(name + "D2S", numbers.in_source).help(fmt::format("of each {} of the output its number in the input", name)).output();
    table.add(name + "S2D", numbers.in_part)
        .help(fmt::format("of each {} of the input its number in the output, or -1", name))
        .output();
  }
  static void declareKind(DataTable& table, const std::string& plural, const std::string& name, KindOfCell& kind) {
    table.add("handle" + plural, kind.wanted).help(fmt::format("find each {} of the output in the input", name));
    declareNumbers(table, name, kind.numbers);
  }

  void matchNodes(const Mesh& whole, const Mesh& part) {
    std::map<std::array<double, 3>, int> at;
    for (Index i = 0; i < whole.nodes() && !same_points_; ++i) {
      const Vec3& p = whole.position[std::size_t(i)];
      at[{p[0], p[1], p[2]}] = int(i);
    }
    points_.in_source.clear();
    points_.in_part.assign(std::size_t(whole.nodes()), -1);
    for (Index i = 0; i < part.nodes(); ++i) {
      const Vec3& p = part.position[std::size_t(i)];
      const auto found = same_points_ ? at.end() : at.find({p[0], p[1], p[2]});
      if (same_points_ ? i >= whole.nodes() : found == at.end())
        throw ComponentError(fmt::format("node {} of {} is no node of {}", i, output_.get()->path(), input_.get()->path()),
                             "nodes at exactly the same places");
      points_.in_source.push_back(same_points_ ? int(i) : found->second);
      points_.in_part[std::size_t(points_.in_source.back())] = int(i);
    }
  }

  template <class Cell>
  void match(const std::vector<Cell>& whole, const std::vector<Cell>& part, Numbers& numbers, const char* name) const {
    const auto sorted = [](Cell cell) { return std::sort(cell.begin(), cell.end()), cell; };
    std::map<Cell, int> at;
    for (std::size_t i = 0; i < whole.size(); ++i) at[sorted(whole[i])] = int(i);
    numbers.in_source.clear();
    numbers.in_part.assign(whole.size(), -1);
    for (std::size_t i = 0; i < part.size(); ++i) {
      Cell cell = part[i];
      for (Index& node : cell) node = Index(points_.in_source[std::size_t(node)]);
      const auto found = at.find(sorted(cell));
      if (found == at.end())
        throw ComponentError(fmt::format("{} {} of {} is none of {}", name, i, output_.get()->path(), input_.get()->path()),
                             "cells that the input has too");
      numbers.in_source.push_back(found->second);
      numbers.in_part[std::size_t(found->second)] = int(i);
    }
  }

  Link<Topology> input_{"topology"}, output_{"topology"};
  bool same_points_ = false;
  Numbers points_;
  KindOfCell edges_, triangles_, quads_, tetrahedra_, hexahedra_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(point_topological_mappings) {
  factory.add<stroma::Mesh2Point>("Mesh2PointTopologicalMapping", "points on the nodes and cells of a mesh");
  factory.add<stroma::SubsetTopologicalMapping>("SubsetTopologicalMapping", "which parts of a mesh those of another are");
}
