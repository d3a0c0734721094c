// SPDX-License-Identifier: LGPL-2.1-or-later
// Rewrites the description of a scene for a changed mesh, as if it had been written that way.
#pragma once
#include <map>
#include <set>
#include <string>
#include <vector>

#include "framework/simulation/simulation.h"
#include "tools/session/mesh_edit.h"

namespace stroma {

/// The remaining entries of parallel lists in which a Lagrangian constraint names points, with data stored per entry.
struct EntriesLeft {
  std::size_t before = 0;
  std::vector<Index> of{};  ///< old positions of the remaining entries
};

/// The effects of a changed mesh on a scene.
struct Followed {
  std::vector<std::string> states{};   ///< paths of those on the mesh
  std::set<std::string> written{};     ///< "path.attribute", or "path." if a whole component was rewritten
  std::vector<std::string> left_out{}; ///< paths of components that no longer act on anything
  std::map<std::string, EntriesLeft> entries{};  ///< by path
};

/// Replaces the mesh of `topology` in `scene`, the description of `simulation`, by that of `edit`, as lists of nodes and cells.
/// Everything indexed by its nodes or cells is updated: states with explicit positions, lists of nodes (removed ones are dropped
/// with their values in parallel lists), values per node and per cell. Regions are replaced by the indices they found.
/// Components left with no nodes or cells are dropped. Throws ComponentError naming whatever cannot be updated.
Followed putMesh(const Simulation& simulation, const Topology& topology, const MeshEdit& edit, SceneDescription& scene);

}  // namespace stroma
