// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "framework/mechanics/state.h"
#include "framework/mechanics/state_topology.h"

namespace stroma {

/// Nodes from a mesh beside it, of which only the cells may be asked for.
inline bool hasNodesOfMesh(const State& child) {
  const Data* use = child.data().find("useTopology");
  return firstTopology(child, false) && !(use && use->print() == "false");
}

/// A state that follows, and of which a scene says neither places nor how many nodes it has, gets those that it follows; each
/// is given by the first of its rows. `always`: whatever the scene says.
inline void takeNodesOf(const State& followed, const std::vector<Index>& first_rows, State& child, bool always = false) {
  for (const char* name : {"position", "rest_position", "size"})
    if (const Data* data = child.data().find(name); !always && data && data->isSet()) return;
  if (child.nodes() == Index(first_rows.size()) || followed.rows_per_node < child.rows_per_node) return;
  if (!always && hasNodesOfMesh(child)) return;
  std::vector<RowKind> kinds;
  std::vector<Vec3> position, rest, velocity;
  for (const Index first : first_rows)
    for (Index row = first; row < first + child.rows_per_node; ++row) {
      position.push_back(followed.position[std::size_t(row)]), rest.push_back(followed.rest_position[std::size_t(row)]);
      velocity.push_back(followed.velocity[std::size_t(row)]);
      if (!child.row_kinds.empty()) kinds.push_back(child.row_kinds[std::size_t(row - first)]);
    }
  child.position = std::move(position), child.rest_position = std::move(rest), child.velocity = std::move(velocity);
  child.row_kinds = std::move(kinds);
}

}  // namespace stroma
