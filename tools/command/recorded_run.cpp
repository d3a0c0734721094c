// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/recorded_run.h"

#include <fmt/format.h>

#include <algorithm>

#include "tools/command/instants.h"
#include "tools/command/recorder.h"
#include "tools/command/session.h"
#include "tools/drawing/contacts.h"
#include "tools/session/checkpoint.h"

namespace stroma::command {
namespace {

/// The scene that wrote `file`: its name may be relative to the folder that the run was started in, which most often is
/// one of those above the folder of the recording.
std::string foundScene(const std::string& scene, const std::string& file, const std::string& folder) {
  std::error_code error;
  if (fs::is_regular_file(scene, error)) return scene;
  if (fs::path(scene).is_absolute())
    throw UsageError(fmt::format("{} names the scene {}, which is not there any more", file, scene));
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
                  file, scene, folder));
}

/// How many positions a state has at an instant.
Index sizeAt(double time, const State& state, const RecordedMeshes& meshes) {
  const Checkpoint* changed = meshesAt(time, meshes);
  if (!changed) return state.size();
  const auto found = changed->values.entries().find(state.path() + ":state:x");
  return found == changed->values.entries().end() ? 0 : Index(found->second.bytes.size() / (row_doubles * sizeof(double)));
}

void checkFrame(const StateFrame& frame, const std::string& file, const State& state, const RecordedMeshes& meshes) {
  const Index size = sizeAt(frame.time, state, meshes);
  if (Index(frame.x.size()) != size || (!frame.v.empty() && frame.v.size() != frame.x.size()))
    throw UsageError(fmt::format("{}: at T = {:g} s there are {} positions (expected {}, as {} has nodes)", file,
                                 frame.time, frame.x.size(), size, state.path()));
}

drawing::Recording instantsIn(const std::string& file, const Simulation& simulation, const RecordedMeshes& meshes) {
  const std::vector<StateSize> recorded = readInstantsHead(file).states;
  drawing::Recording all = readInstants(file), recording;
  for (const State* state : simulation.states()) {
    const auto found = std::find_if(recorded.begin(), recorded.end(),
                                    [state](const StateSize& size) { return size.path == state->path(); });
    if (found == recorded.end())
      throw UsageError(fmt::format("{}: there is no {}: the scene has changed since", file, state->path()));
    recording.push_back(std::move(all[std::size_t(found - recorded.begin())]));
    for (const StateFrame& frame : recording.back()) checkFrame(frame, file, *state, meshes);
  }
  if (recording.empty()) throw UsageError("nothing in the scene moves: there is nothing to show");
  return recording;
}

}  // namespace

RecordedRun recordedRun(const std::string& folder) {
  const std::string instants = instantsFile(folder), checkpoint = (fs::path(folder) / "last.checkpoint").string();
  std::error_code error;
  if (fs::exists(instants, error)) {
    const InstantsHead head = readInstantsHead(instants);
    const std::string there = (fs::path(head.folder) / head.scene).string();
    const bool is_there = fs::is_regular_file(there, error);
    return {is_there ? there : foundScene(head.scene, instants, folder), head.overrides, head.modules};
  }
  if (!fs::exists(checkpoint, error)) {
    const std::string below = (fs::path(folder) / "last").string();
    throw UsageError(
        fmt::format("{}: there is no last.checkpoint, which names the scene (expected a folder of stroma run{})",
                    folder, fs::exists(instantsFile(below), error) ? fmt::format("; did you mean '{}'?", below) : ""));
  }
  return {foundScene(Checkpoint::read(checkpoint).scene, checkpoint, folder), {}, {}};
}

void configureAsRecorded(Session& session, const RecordedRun& run, const Values& values) {
  for (const std::string& file : run.modules) session.modules().open(file);
  configure(session, values);
  std::vector<std::string> texts = run.overrides;
  if (values.count("set")) {
    const auto more = values["set"].as<std::vector<std::string>>();
    texts.insert(texts.end(), more.begin(), more.end());
  }
  session.setOverrides(parseOverrides(texts));
}

RecordedMeshes recordedMeshes(const std::string& folder) {
  RecordedMeshes meshes;
  const auto add = [&meshes](Checkpoint checkpoint) {
    double time = 0;
    Archive clock = checkpoint.values.readable();
    clock.enter("simulation");
    clock.value("time", time);
    meshes.emplace(time, std::move(checkpoint));
  };
  const std::string instants = instantsFile(folder);
  if (fs::exists(instants))
    for (const std::string& bytes : readInstantsMeshes(instants)) add(Checkpoint::fromBytes(bytes, instants));
  else
    for (const std::string& file : meshFilesIn(folder)) add(Checkpoint::read(file));
  return meshes;
}

drawing::Recording recordingIn(const std::string& folder, const Simulation& simulation, const RecordedMeshes& meshes) {
  if (fs::exists(instantsFile(folder))) return instantsIn(instantsFile(folder), simulation, meshes);
  drawing::Recording recording;
  for (const State* state : simulation.states()) {
    const std::string file = (fs::path(folder) / stateFileName(state->path())).string();
    StateRecording one = readRecording(file, state);
    if (!one.unfinished.empty()) fmt::print(stderr, "warning: {}\n", one.unfinished);
    if (one.frames.empty()) throw UsageError(file + ": the file holds no instant");
    for (const StateFrame& frame : one.frames) checkFrame(frame, file, *state, meshes);
    recording.push_back(std::move(one.frames));
  }
  if (recording.empty()) throw UsageError("nothing in the scene moves: there is nothing to show");
  for (const Component* component : drawing::withNodeValues(simulation)) {  // recordings of earlier versions have none
    const std::string file = (fs::path(folder) / drawing::valuesFileName(component->path())).string();
    recording.push_back(fs::exists(file) ? readRecording(file).frames : std::vector<StateFrame>());
  }
  std::size_t least = recording.front().size();
  for (const auto& frames : recording)
    if (!frames.empty()) least = std::min(least, frames.size());
  for (auto& frames : recording)
    if (!frames.empty()) frames.resize(least);
  return recording;
}

std::vector<FileUse> filesOfRecording(const std::string& folder, const Simulation& simulation) {
  std::vector<FileUse> files{{instantsFile(folder), "the recording"},
                             {(fs::path(folder) / "run.actions").string(), "the recording"}};
  for (const std::string& file : recordedFiles(simulation, folder)) files.push_back({file, "the recording"});
  return files;
}

}  // namespace stroma::command
