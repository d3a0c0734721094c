// SPDX-License-Identifier: LGPL-2.1-or-later
// ClusteringEngine: groups of nodes that overlap, before the first step, for PositionBasedDynamicsProjectiveConstraint.
//
// `number` nodes are chosen: the first one, and then again and again the one that is farthest from all chosen (-1: every node). Each
// node belongs to the chosen one that is nearest to it. The group of a chosen node has itself, the nodes that belong to it and all
// neighbours of these, and what neighbours of the group lie nearer to it than `radius`. Ways go along the edges of the cells of
// the first mesh of the node. Without a mesh, or with useTopo="false", ways are straight: a group has all nodes nearer than
// radius, and a node that is in no group joins the nearest one.
//
// `cluster` has the groups as lists in brackets, the chosen node first.
//
// Source: names, attributes and the rules of the groups are SOFA's; farthest points: Gonzalez 1985.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 -9.81">
//   <EulerExplicitSolver/>
//   <RegularGridTopology name="grid" n="5 3 3" min="0 0 0" max="4 2 2"/>
//   <MechanicalObject/>
//   <UniformMass totalMass="1"/>
//   <ClusteringEngine name="groups" position="@grid.position" number="6" radius="1.5"/>
//   <PositionBasedDynamicsProjectiveConstraint cluster="@groups.cluster" stiffness="0.9"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <queue>
#include <set>

#include "components/selection/engine.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_lists.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class ClusteringEngine final : public Engine {
 public:
  void declare(DataTable& table) override {
    table.add("position", position_).help("nodes at rest").unit("m").required();
    table.add("number", number_).help("how many groups; -1: one for each node").min(-1);
    table.add("radius", radius_).help("how far a group reaches").unit("m").min(0);
    table.add("useTopo", along_edges_).help("ways along the edges of the mesh, where there is one");
    table.add("cluster", groups_).help("the groups, in brackets").output();
  }
  void init() override {
    const std::size_t nodes = position_.size();
    if (number_ == 0) throw ComponentError("number is 0: there are no groups", "a number, or -1 for one of each node");
    around_.assign(nodes, {});
    const Topology* mesh = along_edges_ ? firstTopology(*this, true) : nullptr;
    if (mesh) readEdges(mesh->mesh());
    owner_.assign(nodes, 0);
    std::vector<std::size_t> chosen;
    if (number_ < 0)
      for (std::size_t i = 0; i < nodes; ++i) chosen.push_back(i), owner_[i] = i;
    else
      choose(std::min(std::size_t(number_), nodes), mesh != nullptr, chosen);
    const std::vector<std::vector<std::size_t>> groups = mesh ? connectedGroups(chosen) : roundGroups(chosen);
    groups_.clear();
    for (const auto& group : groups) groups_ += fmt::format("{}[{}]", groups_.empty() ? "" : " ", fmt::join(group, ","));
  }

 private:
  void readEdges(const Mesh& mesh) {
    forEachCellList(
        [this](const CellKind& kind, const auto& cells) {
          for (const auto& cell : cells)
            for (const auto& edge : kind.edges) {
              const auto a = std::size_t(cell[std::size_t(edge[0])]), b = std::size_t(cell[std::size_t(edge[1])]);
              if (std::max(a, b) < around_.size()) {
                around_[a].push_back(b);
                around_[b].push_back(a);
              }
            }
        },
        mesh);
    for (std::vector<std::size_t>& next : around_) {
      std::sort(next.begin(), next.end());
      next.erase(std::unique(next.begin(), next.end()), next.end());
    }
  }
  double way(std::size_t a, std::size_t b) const { return (position_[a] - position_[b]).norm(); }

  void choose(std::size_t count, bool by_edges, std::vector<std::size_t>& chosen) {
    std::vector<double> least(position_.size(), std::numeric_limits<double>::infinity());
    for (std::size_t next = 0; chosen.size() < count;) {
      chosen.push_back(next);
      spread(next, chosen.size() - 1, by_edges, least);
      next = std::size_t(std::max_element(least.begin(), least.end()) - least.begin());
      if (!(least[next] > 0)) break;
    }
  }
  void spread(std::size_t from, std::size_t group, bool by_edges, std::vector<double>& least) {
    using Place = std::pair<double, std::size_t>;
    std::priority_queue<Place, std::vector<Place>, std::greater<>> waiting;
    const auto reach = [&](std::size_t node, double distance) {
      if (!(distance < least[node])) return;
      least[node] = distance, owner_[node] = group;
      if (by_edges) waiting.emplace(distance, node);
    };
    if (!by_edges)
      for (std::size_t i = 0; i < position_.size(); ++i) reach(i, way(i, from));
    if (by_edges) reach(from, 0);
    while (!waiting.empty()) {
      const auto [distance, node] = waiting.top();
      waiting.pop();
      if (distance > least[node]) continue;
      for (const std::size_t next : around_[node]) reach(next, distance + way(next, node));
    }
  }

  std::vector<std::vector<std::size_t>> connectedGroups(const std::vector<std::size_t>& chosen) const {
    std::vector<std::vector<std::size_t>> groups;
    for (std::size_t g = 0; g < chosen.size(); ++g) {
      std::vector<std::size_t> group{chosen[g]};
      std::set<std::size_t> known{chosen[g]};
      for (std::size_t at = 0; at < group.size(); ++at)
        for (const std::size_t next : around_[group[at]])
          if ((owner_[group[at]] == g || way(next, chosen[g]) < radius_) && known.insert(next).second) group.push_back(next);
      groups.push_back(std::move(group));
    }
    return groups;
  }
  std::vector<std::vector<std::size_t>> roundGroups(const std::vector<std::size_t>& chosen) const {
    std::vector<std::vector<std::size_t>> groups;
    for (const std::size_t node : chosen) groups.push_back({node});
    for (std::size_t node = 0; node < position_.size(); ++node) {
      bool is_in = false;
      std::size_t nearest = chosen.size();
      for (std::size_t g = 0; g < chosen.size(); ++g) {
        if (chosen[g] == node) continue;
        if (way(node, chosen[g]) < radius_) {
          groups[g].push_back(node);
          is_in = true;
        }
        if (nearest == chosen.size() || way(node, chosen[g]) < way(node, chosen[nearest])) nearest = g;
      }
      if (!is_in && nearest < chosen.size()) groups[nearest].push_back(node);
    }
    return groups;
  }

  std::vector<Vec3> position_;
  int number_ = -1;
  double radius_ = 1;
  bool along_edges_ = true;
  std::string groups_;
  std::vector<std::vector<std::size_t>> around_;  ///< neighbours of each node along edges
  std::vector<std::size_t> owner_;                ///< the group of each node's nearest chosen one
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(clustering_engine) {
  factory.add<stroma::ClusteringEngine>("ClusteringEngine", "groups of nodes that overlap");
}
