// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/recorder.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <filesystem>
#include <set>

#include "framework/scene/output_file.h"
#include "tools/command/instants.h"
#include "tools/drawing/contacts.h"
#include "tools/drawing/recording.h"
#include "tools/session/mesh_changes.h"
#include "tools/session/owned_values.h"

namespace stroma::command {

namespace fs = std::filesystem;
namespace {

constexpr std::string_view mesh_file = "meshes.", mesh_ending = ".checkpoint";

std::string meshFileName(long step) { return fmt::format("{}{:010}{}", mesh_file, step, mesh_ending); }

}  // namespace

std::vector<std::string> meshFilesIn(const std::string& folder) {
  std::vector<std::string> files;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    const std::string name = at->path().filename().string();
    if (name.starts_with(mesh_file) && name.ends_with(mesh_ending)) files.push_back(at->path().string());
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<std::string> recordedFiles(const Simulation& simulation, const std::string& folder) {
  std::vector<std::string> files;
  std::set<std::string> names;
  const auto add = [&](const Component& component, const std::string& name) {
    if (!names.insert(name).second)
      throw std::runtime_error(fmt::format("two states would be recorded in {}: rename {}", name, component.path()));
    files.push_back((fs::path(folder) / name).string());
  };
  for (const State* state : simulation.states()) add(*state, stateFileName(state->path()));
  for (const Component* component : drawing::withNodeValues(simulation)) add(*component, drawing::valuesFileName(component->path()));
  files.push_back((fs::path(folder) / "last.checkpoint").string());
  return files;
}

Recorder::Recorder(Session& session, const std::string& folder, long every)
    : session_(session), every_(every), states_(session.simulation().states()),
      folder_(folder) {
  for (const Component* component : drawing::withNodeValues(session.simulation())) components_.push_back(component->path());
  std::vector<std::string> files = recordedFiles(session.simulation(), folder);
  checkpoint_ = std::move(files.back());
  files.pop_back();
  for (const std::string& file : files) writers_.emplace_back(file);
}

/// A folder that a run left to be looked at is one that the user has named from now on.
void Recorder::takeOver() {
  std::error_code error;
  if (isInstantsFile(instantsFile(folder_))) fs::remove(instantsFile(folder_), error);
  if (error) throw OutputError(instantsFile(folder_), "cannot remove the instants of a run before", error.value());
}

void Recorder::dropCheckpoint() {
  takeOver();
  dropMeshesAfter(-1);
  std::error_code error;
  fs::remove(checkpoint_, error);
  if (error) throw OutputError(checkpoint_, "cannot remove the checkpoint of a run before", error.value());
}

/// Of a run before, or of one that went on further.
void Recorder::dropMeshesAfter(long step) const {
  for (const std::string& file : meshFilesIn(folder_)) {
    std::error_code error;
    if (fs::path(file).filename().string() > meshFileName(step)) fs::remove(file, error);
    if (error) throw OutputError(file, "cannot remove the meshes of a run before", error.value());
  }
}

/// Whether the last file of meshes has those of the run that goes on.
bool Recorder::hasPresentMeshes() const {
  const std::vector<std::string> files = meshFilesIn(folder_);
  if (files.empty() || !session_.simulation().hasChangedMeshes()) return false;
  const auto sceneOf = [](Checkpoint checkpoint) { return checkpoint.values.take(changed_scene_owner); };
  return areTheSame(sceneOf(session_.checkpoint()).entries(), sceneOf(Checkpoint::read(files.back())).entries());
}

void Recorder::goOn() {
  takeOver();
  const Simulation& simulation = session_.simulation();
  dropMeshesAfter(simulation.steps());
  if (hasPresentMeshes()) meshes_ = session_.meshChanges(), states_ = session_.simulation().states();
  const bool is_due = simulation.steps() % every_ == 0;
  bool all_have_it = true;
  std::size_t i = 0;
  for (StateWriter& writer : writers_) {
    const std::optional<double> last = writer.goOn(simulation.time(), is_due, stateOf(i++));
    is_empty_ = is_empty_ && !last;
    all_have_it = all_have_it && last == simulation.time();
  }
  if (is_due && all_have_it) last_step_ = simulation.steps();
  if (is_due && !all_have_it)
    for (i = 0; i < writers_.size(); ++i) writers_[i].goOn(simulation.time(), false, stateOf(i));
}

void Recorder::write() {
  if (is_empty_ || session_.simulation().steps() % every_ == 0) record();
}

void Recorder::record() {
  Simulation& simulation = session_.simulation();
  if (last_step_ == simulation.steps()) return;
  last_step_ = simulation.steps();
  is_empty_ = false;
  simulation.complete();
  if (meshes_ != session_.meshChanges()) writeMeshes();
  std::size_t i = 0;
  forEachWriter([&](StateWriter& writer) {
    const State* state = stateOf(i);
    writer.time(simulation.time());
    if (state) writer.rows("X", *state, state->x()), writer.rows("V", *state, state->v());
    if (!state)  // one that a change of meshes has left out computes nothing
      if (const Component* component = findComponent(simulation.root(), components_[i - states_.size()]))
        for (const auto& [name, numbers] : drawing::valuesOf(*component)) writer.values(name, numbers);
    ++i;
    writer.finish();
  });
}

/// Instants from here on are of these meshes.
void Recorder::writeMeshes() {
  meshes_ = session_.meshChanges();
  states_ = session_.simulation().states();
  if (!session_.simulation().hasChangedMeshes()) return;
  session_.writeCheckpoint((fs::path(folder_) / meshFileName(session_.simulation().steps())).string());
}

template <class Act>
void Recorder::forEachWriter(Act&& act) {
  std::exception_ptr failure;
  for (StateWriter& writer : writers_) {
    try {
      act(writer);
    } catch (const OutputError&) {
      if (!failure) failure = std::current_exception();
    }
  }
  if (failure) std::rethrow_exception(failure);
}

void Recorder::writeCheckpoint() { session_.writeCheckpoint(checkpoint_); }

void Recorder::finish(bool is_whole) {
  std::exception_ptr failure;
  const auto attempt = [&failure](auto&& act) {
    try {
      act();
    } catch (const OutputError&) {
      if (!failure) failure = std::current_exception();
    }
  };
  attempt([this] { record(); });
  attempt([this] { forEachWriter([](StateWriter& writer) { writer.close(); }); });
  if (is_whole && !failure) attempt([this] { writeCheckpoint(); });
  if (failure) std::rethrow_exception(failure);
}

std::vector<std::string> Recorder::files() const {
  std::vector<std::string> files = meshFilesIn(folder_);
  for (const StateWriter& writer : writers_) files.push_back(writer.path());
  if (fs::exists(checkpoint_)) files.push_back(checkpoint_);
  return files;
}

}  // namespace stroma::command
