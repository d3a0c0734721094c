// SPDX-License-Identifier: LGPL-2.1-or-later
// Folders with a recording: what `stroma run --record DIR` wrote, or what a run without it has left
// (default_recording.h).
#pragma once
#include <string>
#include <vector>

#include "tools/command/options.h"
#include "tools/drawing/recording.h"
#include "tools/session/file_uses.h"
#include "tools/session/session.h"

namespace stroma::command {

/// What it takes to load the scene of a recording again.
struct RecordedRun {
  std::string scene;                   ///< file, as it is found from here
  std::vector<std::string> overrides;  ///< as --set had them; none where the folder does not tell
  std::vector<std::string> modules;    ///< as --module had them; none where the folder does not tell
};

/// Throws UsageError when the folder does not name its scene, or the scene is not there any more.
RecordedRun recordedRun(const std::string& folder);

/// As configure(), with what the run was given; the overrides of `values` come after those of the run.
void configureAsRecorded(Session& session, const RecordedRun& run, const Values& values);

/// What the folder has of changes of meshes. Throws std::runtime_error.
RecordedMeshes recordedMeshes(const std::string& folder);

/// The instants in the folder, which must fit the states of the scene with these meshes. Throws std::runtime_error.
drawing::Recording recordingIn(const std::string& folder, const Simulation& simulation, const RecordedMeshes& meshes);

/// The files of a recording that are, or could be, in the folder: what must not be written over.
std::vector<FileUse> filesOfRecording(const std::string& folder, const Simulation& simulation);

}  // namespace stroma::command
