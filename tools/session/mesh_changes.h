// SPDX-License-Identifier: LGPL-2.1-or-later
// Meshes that change while a scene runs. The scene is loaded again with the other mesh, as one that could have been written so, and
// the run goes on in it from where it is: one way for all that depends on a mesh, and for what a scene may hold one day.
#pragma once
#include <string>
#include <vector>

#include "framework/scene/modules.h"
#include "framework/simulation/simulation.h"

namespace stroma {

/// Makes the changes that components of the scene (MeshChanger) plan before the next step. False: there are none. `notes` gets
/// what the changed scene warns of, and what begins anew in it. Throws ComponentError with a sentence; nothing has changed then.
bool makeMeshChanges(Simulation& simulation, Factory& factory, Modules& modules, std::vector<std::string>& notes);

}  // namespace stroma
