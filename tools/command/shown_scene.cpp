// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/shown_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "framework/simulation/checkpoint.h"
#include "tools/command/command.h"
#include "tools/command/recorder.h"

namespace fs = std::filesystem;

namespace stroma::command {

std::string sceneOf(const std::string& folder) {
  const std::string checkpoint = (fs::path(folder) / "last.checkpoint").string();
  if (!fs::exists(checkpoint))
    throw UsageError(fmt::format(
        "{}: there is no last.checkpoint, which names the scene (expected a folder of stroma run --record)", folder));
  const std::string scene = Checkpoint::read(checkpoint).scene;
  std::error_code error;
  if (fs::is_regular_file(scene, error)) return scene;
  if (fs::path(scene).is_absolute())
    throw UsageError(fmt::format("{} names the scene {}, which is not there any more", checkpoint, scene));
  fs::path above = fs::canonical(folder);
  while (true) {
    if (const fs::path found = above / scene; fs::is_regular_file(found, error))
      return found.lexically_normal().string();
    if (above == above.parent_path()) break;
    above = above.parent_path();
  }
  throw UsageError(
      fmt::format("{} names the scene {}, which is neither here nor in {} or a folder above it (expected the scene at "
                  "its place, or "
                  "the command in the folder that the run was started in)",
                  checkpoint, scene, folder));
}

drawing::Recording recordingIn(const std::string& folder, const Simulation& simulation) {
  drawing::Recording recording;
  for (const State* state : simulation.states()) {
    const std::string file = (fs::path(folder) / stateFileName(state->path())).string();
    StateRecording one = readRecording(file);
    if (!one.unfinished.empty()) fmt::print(stderr, "warning: {}\n", one.unfinished);
    if (one.frames.empty()) throw UsageError(file + ": the file holds no instant");
    for (const StateFrame& frame : one.frames)
      if (Index(frame.x.size()) != state->size() || (!frame.v.empty() && frame.v.size() != frame.x.size()))
        throw UsageError(fmt::format("{}: at T = {:g} s there are {} positions (expected {}, as {} has nodes)", file,
                                     frame.time, frame.x.size(), state->size(), state->path()));
    recording.push_back(std::move(one.frames));
  }
  if (recording.empty()) throw UsageError("nothing in the scene moves: there is nothing to show");
  std::size_t least = recording.front().size();
  for (const auto& frames : recording) least = std::min(least, frames.size());
  for (auto& frames : recording) frames.resize(least);
  return recording;
}

std::vector<FileUse> filesOfRecording(const std::string& folder, const Simulation& simulation) {
  std::vector<FileUse> files;
  for (const std::string& file : recordedFiles(simulation, folder)) files.push_back({file, "the recording"});
  files.push_back({(fs::path(folder) / "run.actions").string(), "the recording"});
  return files;
}

void leaveOutputs(Simulation& simulation, const std::string& why) {
  std::vector<std::string> left;
  for (const Observer* observer : simulation.observers())
    if (!observer->files().empty()) left.push_back(observer->path());
  simulation.dropObservers();
  if (left.empty() || why.empty()) return;
  fmt::print(stderr, "note: {} write{} no file {}\n", fmt::join(left, ", "), left.size() == 1 ? "s" : "", why);
}

}  // namespace stroma::command
