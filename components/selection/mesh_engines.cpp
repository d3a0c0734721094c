// SPDX-License-Identifier: LGPL-2.1-or-later
// Parts of a mesh, holes of a surface that are closed, and the nodes nearest to places, before the first step.
//
// MeshSubsetEngine: position, the nodes `indices` of inputPosition in their order; edges, triangles, quads, tetrahedra and
//   hexahedra, those of the input whose nodes are all among them, with their numbers there.
// MeshClosingEngine: position and triangles, inputPosition and inputTriangles with each hole closed: a node at the mean of its
//   border, and triangles from there to the edges of the border, turned as their neighbours. quads are those of inputQuads.
//   closingPosition and closingTriangles are the lids alone; indices lists the nodes of each lid in brackets, its middle last.
// ProximityROI: indices, of the nodes that are nearer to one of `centers` than its radius the N nearest ones, of nodes that are as near
//   the later ones; distance, how near each is. They come as they stand in the heap that keeps them. The nodes are `position`, else
//   the rest positions of the state of the node or above.
//
// Source: names and attributes are SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerExplicitSolver/>
//   <MeshTopology name="net" position="0 0 0  1 0 0  1 1 0  0 1 0  2 0 0" triangles="0 1 2  0 2 3  1 4 2"/>
//   <MeshSubsetEngine name="square" inputPosition="@net.position" inputTriangles="@net.triangles" indices="0 1 2 3"/>
//   <MeshClosingEngine name="closed" inputPosition="@square.position" inputTriangles="@square.triangles"/>
//   <TriangleSetTopologyContainer position="@closed.position" triangles="@closed.triangles"/>
//   <MechanicalObject name="dofs"/>
//   <UniformMass totalMass="1"/>
//   <ProximityROI name="near" centers="0 0 0" radii="0.8" N="2"/>
//   <FixedProjectiveConstraint indices="@near.indices"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "components/selection/engine.h"
#include "framework/mechanics/state_positions.h"
#include "framework/mechanics/state_topology.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

/// An engine that makes a mesh.
class MeshEngine : public Engine {
 public:
  std::string roleText() const override { return "mesh engine"; }

 protected:
  static void checkNodes(const auto& cells, std::size_t nodes, const char* name) {
    for (const auto& cell : cells)
      for (const Index node : cell)
        if (node < 0 || std::size_t(node) >= nodes) throw ComponentError(fmt::format("{} names node {} of {}", name, node, nodes));
  }
};

class MeshSubsetEngine final : public MeshEngine {
 public:
  void declare(DataTable& table) override {
    table.add("inputPosition", from_.position).help("nodes of the mesh").unit("m");
    table.add("inputEdges", from_.edges).help("its edges");
    table.add("inputTriangles", from_.triangles).help("its triangles");
    table.add("inputQuads", from_.quads).help("its quads");
    table.add("inputTetrahedra", from_.tetrahedra).help("its tetrahedra");
    table.add("inputHexahedra", from_.hexahedra).help("its hexahedra");
    table.add("indices", indices_).help("which nodes");
    table.add("position", part_.position).help("those nodes").unit("m").output();
    table.add("edges", part_.edges).help("edges between them").output();
    table.add("triangles", part_.triangles).help("triangles of them").output();
    table.add("quads", part_.quads).help("quads of them").output();
    table.add("tetrahedra", part_.tetrahedra).help("tetrahedra of them").output();
    table.add("hexahedra", part_.hexahedra).help("hexahedra of them").output();
  }
  void init() override {
    if (indices_.empty()) warn("indices names no node", "check that the selection linked here contains nodes");
    part_ = Mesh();
    std::vector<Index> number(from_.position.size(), -1);
    for (const int node : indices_) {
      if (node < 0 || std::size_t(node) >= number.size())
        throw ComponentError(fmt::format("indices names {}, and there are {} positions", node, number.size()));
      number[std::size_t(node)] = Index(part_.position.size());
      part_.position.push_back(from_.position[std::size_t(node)]);
    }
    take(number, from_.edges, part_.edges, "inputEdges");
    take(number, from_.triangles, part_.triangles, "inputTriangles");
    take(number, from_.quads, part_.quads, "inputQuads");
    take(number, from_.tetrahedra, part_.tetrahedra, "inputTetrahedra");
    take(number, from_.hexahedra, part_.hexahedra, "inputHexahedra");
  }

 private:
  template <class Cell>
  static void take(const std::vector<Index>& number, const std::vector<Cell>& from, std::vector<Cell>& to, const char* name) {
    checkNodes(from, number.size(), name);
    for (Cell cell : from) {
      for (Index& node : cell) node = number[std::size_t(node)];
      if (std::find(cell.begin(), cell.end(), Index(-1)) == cell.end()) to.push_back(cell);
    }
  }
  Mesh from_, part_;
  std::vector<int> indices_;
};

class MeshClosingEngine final : public MeshEngine {
 public:
  void declare(DataTable& table) override {
    table.add("inputPosition", from_.position).help("nodes of the surface").unit("m");
    table.add("inputTriangles", from_.triangles).help("its triangles");
    table.add("inputQuads", from_.quads).help("its quads");
    table.add("position", closed_.position).help("nodes, those of the lids last").unit("m").output();
    table.add("triangles", closed_.triangles).help("triangles, those of the lids last").output();
    table.add("quads", closed_.quads).help("the quads").output();
    table.add("indices", loops_).help("nodes of each lid, in brackets").output();
    table.add("closingPosition", lids_.position).help("nodes of the lids: of each its border and its middle").unit("m").output();
    table.add("closingTriangles", lids_.triangles).help("triangles of the lids").output();
  }
  void init() override {
    checkNodes(from_.triangles, from_.position.size(), "inputTriangles");
    checkNodes(from_.quads, from_.position.size(), "inputQuads");
    closed_ = Mesh(from_), lids_ = Mesh(), loops_.clear();
    const std::map<Index, Index> next = border();
    std::set<Index> left;
    for (const auto& [node, other] : next) left.insert(node);
    while (!left.empty()) {
      std::vector<Index> loop;
      for (Index node = *left.begin(); left.erase(node) > 0; node = next.at(node)) loop.push_back(node);
      if (next.at(loop.back()) != loop.front())
        throw ComponentError("the border of a hole meets another one", "holes that do not touch");
      close(loop);
    }
    if (next.empty()) inform("the surface has no hole");
  }

 private:
  /// From each node of a border the next one, along the sides of the cells.
  std::map<Index, Index> border() const {
    std::set<std::pair<Index, Index>> sides;
    const auto add = [&sides](const auto& cells) {
      for (const auto& cell : cells)
        for (std::size_t i = 0; i < cell.size(); ++i) {
          const Index a = cell[i], b = cell[(i + 1) % cell.size()];
          if (sides.erase({b, a}) == 0) sides.insert({a, b});
        }
    };
    add(from_.triangles), add(from_.quads);
    std::map<Index, Index> next;
    for (const auto& [a, b] : sides)
      if (!next.emplace(a, b).second) throw ComponentError(fmt::format("two holes meet in node {}", a), "holes that do not touch");
    for (const auto& [a, b] : next)
      if (!next.count(b))
        throw ComponentError(fmt::format("the cells at node {} are not turned alike", b), "a surface with one outer side");
    return next;
  }
  void close(const std::vector<Index>& loop) {
    Vec3 middle = Vec3::Zero();
    const Index first = Index(lids_.position.size()), count = Index(loop.size()), own = Index(closed_.position.size());
    for (Index i = 0; i < count; ++i) {
      const Index node = loop[std::size_t(i)], before = loop[std::size_t((i + count - 1) % count)];
      middle += from_.position[std::size_t(node)] / double(count);
      lids_.position.push_back(from_.position[std::size_t(node)]);
      closed_.triangles.push_back({own, node, before});
      lids_.triangles.push_back({first + count, first + i, first + (i + count - 1) % count});
    }
    closed_.position.push_back(middle), lids_.position.push_back(middle);
    loops_ += fmt::format("{}[{},{}]", loops_.empty() ? "" : " ", fmt::join(loop, ","), own);
  }
  Mesh from_, closed_, lids_;
  std::string loops_;
};

class ProximityROI final : public Engine {
 public:
  std::string roleText() const override { return "selection"; }
  void declare(DataTable& table) override {
    table.add("centers", centers_).help("places").unit("m").required();
    table.add("radii", radii_).help("how near to each; the last one also for the places behind").unit("m").min(0).required();
    table.add("N", most_).help("how many nodes at most").min(1).required();
    table.add("position", position_)
        .alias("rest_position")
        .help("nodes; those of the state of the node or above by default")
        .unit("m");
    table.add("indices", indices_).alias("pointIndices").help("the nearest nodes, as the heap of them has them").output();
    table.add("pointsInROI", points_).help("their positions").unit("m").output();
    table.add("distance", distances_).help("from the nearest place").unit("m").output();
    table.add("indicesOut", others_).help("the other nodes").output();
    for (const char* name : {"drawSphere", "drawPoints", "drawSize", "isVisible"}) table.addVisualOnly(name);
  }
  void init() override {
    if (centers_.empty() || radii_.empty())
      throw ComponentError("centers or radii is empty", "a radius for each centre, or one for all");
    if (radii_.size() > centers_.size())
      throw ComponentError(fmt::format("there are {} radii for {} centers", radii_.size(), centers_.size()),
                           "at most one for each");
    findPositions();
    indices_.clear();
    others_.clear();
    points_.clear();
    distances_.clear();
    using Near = std::pair<double, int>;
    std::vector<Near> near;
    const auto by_distance = [](const Near& a, const Near& b) { return a.first < b.first; };
    for (int i = 0; i < int(position_.size()); ++i) {
      const double distance = distanceOf(position_[std::size_t(i)]);
      const bool is_full = near.size() >= std::size_t(most_);
      if (!std::isfinite(distance) || (is_full && near.front().first < distance)) {
        others_.push_back(i);
        continue;
      }
      if (is_full) {
        others_.push_back(near.front().second);
        std::pop_heap(near.begin(), near.end(), by_distance);
        near.pop_back();
      }
      near.emplace_back(distance, i);
      std::push_heap(near.begin(), near.end(), by_distance);
    }
    for (const auto& [distance, i] : near)
      indices_.push_back(i), points_.push_back(position_[std::size_t(i)]), distances_.push_back(distance);
    if (indices_.empty()) warn("no node is that near to one of the places", "larger radii");
  }

 private:
  /// To the nearest place whose radius reaches as far; else infinite.
  double distanceOf(const Vec3& p) const {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t c = 0; c < centers_.size(); ++c) {
      const double distance = (p - centers_[c]).norm();
      if (distance < radii_[std::min(c, radii_.size() - 1)]) least = std::min(least, distance);
    }
    return least;
  }
  void findPositions() {
    if (data().find("position")->isSet()) return;
    for (const bool upwards : {false, true}) {
      if (const auto* state = find<State>(upwards)) return void(position_ = nodePlaces(*state, state->rest_position));
      if (const auto* topology = firstTopology(*this, upwards)) return void(position_ = topology->mesh().position);
    }
    throw ComponentError("there are no nodes to select from", "a state or topology in the node or above, or position");
  }
  std::vector<Vec3> centers_, position_, points_;
  std::vector<double> radii_, distances_;
  std::vector<int> indices_, others_;
  int most_ = 1;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(mesh_engines) {
  factory.add<stroma::MeshSubsetEngine>("MeshSubsetEngine", "a part of a mesh by its nodes");
  factory.add<stroma::MeshClosingEngine>("MeshClosingEngine", "a surface whose holes are closed");
  factory.add<stroma::ProximityROI>("ProximityROI", "selects the nodes nearest to places");
}
