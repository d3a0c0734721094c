// SPDX-License-Identifier: LGPL-2.1-or-later
// Mesh changes requested by the caller of a run rather than by a component of the scene (tools/session/mesh_changes.h).
#pragma once
#include <string>
#include <vector>

#include "framework/simulation/mesh_changer.h"
#include "tools/session/mesh_changes.h"

namespace stroma {

/// Applies them between two steps, in order; each uses the numbering left by the previous one. `who` is named in errors.
/// Throws ComponentError, and then nothing has changed.
MeshChangesMade makeGivenChanges(Simulation& simulation, Factory& factory, Modules& modules, std::vector<MeshChange> changes,
                                 const std::string& who);

}  // namespace stroma
