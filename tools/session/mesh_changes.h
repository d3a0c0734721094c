// SPDX-License-Identifier: LGPL-2.1-or-later
// Meshes that change in a running scene. The scene is loaded again with the new mesh, as if it had been written that way, and
// the run continues from its present state. This single mechanism covers every component that depends on a mesh.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "framework/scene/modules.h"
#include "framework/simulation/simulation.h"
#include "tools/session/checkpoint.h"

namespace stroma {

/// New numbers of the nodes of states, or -1, by the path of the state. A state that is not listed keeps its nodes, or has new
/// ones that no list maps to.
using NodesNow = std::map<std::string, std::vector<Index>>;

struct MeshChangesMade {
  bool any = false;
  NodesNow nodes{};
  std::vector<std::string> notes{};  ///< warnings of the changed scene, and data that was reset
};

/// Applies the changes that components of the scene (MeshChanger) plan before the next step. Throws ComponentError, and then
/// nothing has changed. If a component, such as a tie, names nodes of several changed meshes, those before the failed one have
/// changed.
MeshChangesMade makeMeshChanges(Simulation& simulation, Factory& factory, Modules& modules);

/// The changes made so far, for another simulation of the scene: values of one owner of a checkpoint, empty if no mesh has
/// changed.
constexpr const char* changed_scene_owner = "changed scene";
void writeChangedScene(const Simulation& simulation, Archive& archive);
/// Gives the scene the meshes of such values, which must belong to it, or its original meshes if there are none. Does nothing
/// if it already has them. Everything restarts: call Simulation::restore() afterwards. Throws std::runtime_error, and then the
/// scene is in an undefined state.
void takeChangedScene(Simulation& simulation, Archive values, Factory& factory, Modules& modules);

/// The times at which the meshes of a recorded run have changed [s], each with the checkpoint that has the new meshes.
using RecordedMeshes = std::map<double, Checkpoint>;
/// Null: the scene has its original meshes.
const Checkpoint* meshesAt(double time, const RecordedMeshes& meshes);

}  // namespace stroma
