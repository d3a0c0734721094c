// SPDX-License-Identifier: LGPL-2.1-or-later
// Meshes that change while a scene runs. The scene is loaded again with the other mesh, as one that could have been written so, and
// the run goes on in it from where it is: one way for all that depends on a mesh, and for what a scene may hold one day.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "framework/scene/modules.h"
#include "framework/simulation/simulation.h"

namespace stroma {

/// Where the nodes of states have gone: of each before, its number now, or -1, by the path of the state. A state that is not
/// named has those that it had, or others that no list leads to.
using NodesNow = std::map<std::string, std::vector<Index>>;

struct MeshChangesMade {
  bool any = false;
  NodesNow nodes{};
  std::vector<std::string> notes{};  ///< what the changed scene warns of, and what begins anew in it
};

/// Makes the changes that components of the scene (MeshChanger) plan before the next step. Throws ComponentError with a sentence;
/// nothing has changed then.
MeshChangesMade makeMeshChanges(Simulation& simulation, Factory& factory, Modules& modules);

}  // namespace stroma
