// SPDX-License-Identifier: LGPL-2.1-or-later
// Meshes that change while a scene runs. The scene is loaded again with the other mesh, as one that could have been written so, and
// the run goes on in it from where it is: one way for all that depends on a mesh, and for what a scene may hold one day.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "framework/scene/modules.h"
#include "framework/simulation/simulation.h"
#include "tools/session/checkpoint.h"

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
/// nothing has changed then, or where something names nodes of several meshes that change, as a tie does, those before the one that fails
/// have.
MeshChangesMade makeMeshChanges(Simulation& simulation, Factory& factory, Modules& modules);

/// What such changes have made of the scene, for another simulation of it: values of one owner of a checkpoint, and none where no mesh
/// has changed.
constexpr const char* changed_scene_owner = "changed scene";
void writeChangedScene(const Simulation& simulation, Archive& archive);
/// The scene with the meshes of such values, which are of this scene; without any, with its first ones.
/// Nothing happens where it has them. Everything begins anew in it: Simulation::restore() is to follow. Throws std::runtime_error;
/// the scene is then anywhere between.
void takeChangedScene(Simulation& simulation, Archive values, Factory& factory, Modules& modules);

/// Where the meshes of a recorded run have changed: from each of these times on they are those of a checkpoint [s].
using RecordedMeshes = std::map<double, Checkpoint>;
/// Null: the scene has the meshes that it was written with.
const Checkpoint* meshesAt(double time, const RecordedMeshes& meshes);

}  // namespace stroma
