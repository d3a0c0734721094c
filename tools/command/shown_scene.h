// SPDX-License-Identifier: LGPL-2.1-or-later
// What subcommands share that show a scene, or a recorded run of one: `stroma view` and `stroma picture`.
#pragma once
#include <string>
#include <vector>

#include "framework/simulation/file_uses.h"
#include "framework/simulation/simulation.h"
#include "tools/drawing/recording.h"

namespace stroma::command {

/// The scene that wrote a recording, by the checkpoint in its folder. Its name may be relative to the folder that the run was
/// started in, which most often is one of those above. Throws UsageError.
std::string sceneOf(const std::string& folder);

/// The instants in the folder, which must fit the states of the scene. Throws std::runtime_error.
drawing::Recording recordingIn(const std::string& folder, const Simulation& simulation);

/// What must not be written over.
std::vector<FileUse> filesOfRecording(const std::string& folder, const Simulation& simulation);

/// Observers write nothing. A note says so, unless `why` ("in a view") is empty.
void leaveOutputs(Simulation& simulation, const std::string& why);

}  // namespace stroma::command
