// SPDX-License-Identifier: LGPL-2.1-or-later
// Changes of meshes that whoever leads a run gives, and no component of the scene plans (tools/session/mesh_changes.h).
#pragma once
#include <string>
#include <vector>

#include "framework/simulation/mesh_changer.h"
#include "tools/session/mesh_changes.h"

namespace stroma {

/// Makes them between two steps, in order: each has the numbers that those before it have left. `who` is named where one cannot be
/// made. Throws ComponentError with a sentence; nothing has changed then.
MeshChangesMade makeGivenChanges(Simulation& simulation, Factory& factory, Modules& modules, std::vector<MeshChange> changes,
                                 const std::string& who);

}  // namespace stroma
