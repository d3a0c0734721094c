// SPDX-License-Identifier: LGPL-2.1-or-later
// The scene with another mesh, as a scene that could have been written so.
#pragma once
#include <map>
#include <set>
#include <string>
#include <vector>

#include "framework/simulation/simulation.h"
#include "tools/session/mesh_edit.h"

namespace stroma {

/// Of lists of one length in which a Lagrangian constraint names points, and of which it remembers one thing each.
struct EntriesLeft {
  std::size_t before = 0;
  std::vector<Index> of{};  ///< places before of those that stay
};

/// What a changed mesh has changed in a scene.
struct Followed {
  std::vector<std::string> states{};   ///< paths of those on the mesh
  std::set<std::string> written{};     ///< "path.attribute", or "path." where all of a component is anew
  std::vector<std::string> left_out{}; ///< paths of components that act on nothing any more
  std::map<std::string, EntriesLeft> entries{};  ///< by path
};

/// Puts the mesh of `edit` in the place of that of `topology` into `scene`, the description of `simulation`: as lists of nodes and cells.
/// What counts its nodes or cells follows: states with positions of their own, lists of nodes (what goes is left out, with what
/// else a list says of it), values per node and per cell. Regions are replaced by the numbers that they found.
/// A component whose list of nodes or cells is empty then is left out. Throws ComponentError naming what cannot follow.
Followed putMesh(const Simulation& simulation, const Topology& topology, const MeshEdit& edit, SceneDescription& scene);

}  // namespace stroma
