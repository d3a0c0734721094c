// SPDX-License-Identifier: LGPL-2.1-or-later
// Transfers the checkpoint of a run to the same scene with changed meshes.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "framework/simulation/simulation.h"
#include "tools/session/changed_description.h"
#include "tools/session/mesh_edit.h"

namespace stroma {

/// A changed mesh, by its path, and the states on it.
struct ChangedMesh {
  std::string path;
  MeshEdit edit;
  Followed followed{};
};

/// The checkpoint of `before` converted for `after`: positions and velocities by node, component data by node and by cell, and
/// unchanged times. New points are interpolated by their weights. Any other data is reset, and its owner is listed in `anew`.
/// Solvers restart, but for what they keep under names that begin with "after_mesh_changes". Throws ComponentError if a component
/// cannot continue.
Archive carriedValues(Simulation& before, Simulation& after, const std::vector<ChangedMesh>& meshes,
                      std::vector<std::string>& anew);

}  // namespace stroma
