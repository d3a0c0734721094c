// SPDX-License-Identifier: LGPL-2.1-or-later
// What a run remembers, for the same scene with other meshes.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "framework/simulation/simulation.h"
#include "tools/session/changed_description.h"
#include "tools/session/mesh_edit.h"

namespace stroma {

/// A mesh that has changed, by its path, and the states on it.
struct ChangedMesh {
  std::string path;
  MeshEdit edit;
  Followed followed{};
};

/// The checkpoint of `before` for `after`: positions and velocities by node, memories by node and by cell, and times as they are. A new
/// point lies and moves as its shares say. A memory that is of neither begins anew: its owner is named in `anew`. Solvers begin anew.
/// Throws ComponentError: what cannot go on.
Archive carriedValues(Simulation& before, Simulation& after, const std::vector<ChangedMesh>& meshes,
                      std::vector<std::string>& anew);

}  // namespace stroma
