// SPDX-License-Identifier: LGPL-2.1-or-later
// Which mesh belongs to a state. A topology fits a state when it has as many nodes.
//
// 1. The topology that the attribute of the asking component links, when it is given.
// 2. Else the nearest node that holds one that fits, from the node of the asking component upwards. Of several in its
//    own node it is the last, of several in a node above the first, as in SOFA: a grid that gives the nodes may stand
//    beside a container of tetrahedra that are cut from it. A topological mapping that fills a container does not count.
//
// Topologies that do not fit are passed over; when none fits, the error names them.
#pragma once
#include <string_view>

#include "framework/mechanics/state.h"
#include "framework/mesh/topology.h"

namespace stroma {

struct CellKind;

/// What a component needs of the nodes of a mesh.
enum class MeshNodes {
  all,    ///< as many as the state has
  first,  ///< at most as many: the mesh has the state's first nodes. One with all of them is preferred.
};

/// The mesh of `state` for `asker`, initialised; null when no node from the asker's upwards holds a topology. Throws
/// ComponentError when the linked one does not fit or none does. `attribute` is the name of the link.
const Topology* findTopology(const Component& asker, const State& state, const Link<Topology>& link,
                             MeshNodes nodes = MeshNodes::all, std::string_view attribute = "topology");

/// The attribute `topology` of a component that acts on a state.
class TopologyLink {
 public:
  /// `mesh` says in the help which one it is: "surface", "mesh that holds the cells".
  void declare(DataTable& table, const std::string& mesh);
  /// findTopology() with it.
  const Topology* find(const Component& asker, const State& state, MeshNodes nodes = MeshNodes::all) const {
    return findTopology(asker, state, link_, nodes);
  }
  /// A mesh with all nodes of the state and cells of this kind. Throws ComponentError when there is none.
  const Mesh& meshWith(const CellKind& kind, const Component& asker, const State& state) const;

 private:
  Link<Topology> link_{"topology"};
};

/// The same for `count` positions that `whose` has (for the message), without a link.
const Topology* findTopology(const Component& asker, Index count, std::string_view whose, MeshNodes nodes);

/// The same as a state's own, for whoever can do without a mesh: null when none fits.
const Topology* topologyOf(const State& state);

/// Every topology that fits in the node where topologyOf() finds one, in document order.
std::vector<const Topology*> topologiesOf(const State& state);

/// The topology whose nodes a component without its own uses: the first of its node, else (upwards = true) the first of
/// the nearest node above that has one; initialised, or null.
const Topology* firstTopology(const Component& asker, bool upwards);

}  // namespace stroma
