// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/mechanics/state_topology.h"

#include <fmt/format.h>

#include "framework/mesh/cell_lists.h"
#include "framework/mesh/mesh_loader.h"

namespace stroma {

namespace {

/// How many nodes a mesh must have, and whose they are.
struct Wanted {
  Index count;
  std::string_view whose;
  MeshNodes nodes;
  std::string_view attribute;

  bool fits(const Topology& topology) const {
    const Index found = topology.mesh().nodes();
    return nodes == MeshNodes::all ? found == count : found <= count;
  }
};

using Topologies = std::vector<const Topology*>;

/// A topology that a search may answer, initialised; or null. Throws DependencyFailed for a mesh that could not be read.
const Topology* answerOf(Component& component) {
  if (component.hasFailed() && dynamic_cast<MeshLoader*>(&component)) component.ensureReady();
  auto* topology = dynamic_cast<Topology*>(&component);
  if (!topology || !topology->answersLookup()) return nullptr;
  return topology->ensureReady(), topology;
}

Topologies topologiesIn(const Node& node) {
  Topologies found;
  for (const auto& component : node.components())
    if (const Topology* topology = answerOf(*component)) found.push_back(topology);
  return found;
}

/// Those that fit in the nearest node from `from` upwards that has any; `passed` are those on the way that do not.
Topologies nearestThatFit(const Node& from, const Wanted& wanted, Topologies& passed) {
  Topologies fitting;
  for (const Node* node = &from; node && fitting.empty(); node = node->parent())
    for (const Topology* topology : topologiesIn(*node)) (wanted.fits(*topology) ? fitting : passed).push_back(topology);
  return fitting;
}

const Topology* choose(const Topologies& fitting, const Node& own) {
  if (fitting.empty()) return nullptr;
  return &fitting.front()->node() == &own ? fitting.back() : fitting.front();
}

[[noreturn]] void failFit(const Topologies& topologies, const Wanted& wanted) {
  std::string found;
  for (const Topology* topology : topologies)
    found += fmt::format("{}{} has {} nodes", found.empty() ? "" : ", ", topology->path(), topology->mesh().nodes());
  throw ComponentError(fmt::format("{} and {} has {}", found, wanted.whose, wanted.count),
                       wanted.nodes == MeshNodes::all ? "a mesh and a state of the same nodes" : "a mesh with no more nodes than that",
                       fmt::format("{}=\"@path\" of the mesh that belongs to {}", wanted.attribute, wanted.whose));
}

const Topology* search(const Node& own, Wanted wanted) {
  const MeshNodes needed = wanted.nodes;
  Topologies passed;
  wanted.nodes = MeshNodes::all;
  const Topology* found = choose(nearestThatFit(own, wanted, passed), own);
  wanted.nodes = needed;
  if (!found && needed == MeshNodes::first) {
    Topologies too_large;
    found = choose(nearestThatFit(own, wanted, too_large), own);
  }
  if (!found && !passed.empty()) failFit(passed, wanted);
  return found;
}

}  // namespace

const Topology* findTopology(const Component& asker, const State& state, const Link<Topology>& link, MeshNodes nodes,
                             std::string_view attribute) {
  const std::string whose = state.path();
  const Wanted wanted{state.nodes(), whose, nodes, attribute};
  const Topology* linked = link.get();
  if (linked && !wanted.fits(*linked)) failFit({linked}, wanted);
  return linked ? linked : search(asker.node(), wanted);
}

void TopologyLink::declare(DataTable& table, const std::string& mesh) {
  table.addLink("topology", link_).help(mesh + "; that of this node or the nearest above by default");
}

const Mesh& TopologyLink::meshWith(const CellKind& kind, const Component& asker, const State& state) const {
  const Topology* topology = find(asker, state);
  std::size_t cells = 0;
  const auto count = [&](const CellKind& listed, const auto& list) {
    if (listed.type == kind.type) cells = list.size();
  };
  if (topology) forEachCellList(count, topology->mesh());
  if (cells == 0)
    throw ComponentError(topology ? fmt::format("{} has no {}", topology->path(), kind.plural)
                                  : fmt::format("no mesh in this node or above has {}", kind.plural),
                         fmt::format("a topology with {}", kind.plural));
  return topology->mesh();
}

const Topology* findTopology(const Component& asker, Index count, std::string_view whose, MeshNodes nodes) {
  return search(asker.node(), {count, whose, nodes, "topology"});
}

const Topology* topologyOf(const State& state) { return choose(topologiesOf(state), state.node()); }

std::vector<const Topology*> topologiesOf(const State& state) {
  Topologies passed;
  return nearestThatFit(state.node(), {state.nodes(), {}, MeshNodes::all, {}}, passed);
}

const Topology* firstTopology(const Component& asker, bool upwards) {
  for (const Node* node = &asker.node(); node; node = upwards ? node->parent() : nullptr)
    for (const auto& component : node->components())
      if (const Topology* topology = answerOf(*component)) return topology;
  return nullptr;
}

}  // namespace stroma
