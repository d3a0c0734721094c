// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/recorder.h"

#include <fmt/format.h>

#include <filesystem>
#include <set>

namespace stroma::command {

Recorder::Recorder(Session& session, const std::string& folder, bool goes_on)
    : session_(session),
      checkpoint_((std::filesystem::path(folder) / "last.checkpoint").string()),
      states_(session.simulation().states()) {
  std::set<std::string> names;
  for (const State* state : states_) {
    const std::string name = stateFileName(state->path());
    if (!names.insert(name).second)
      throw std::runtime_error(fmt::format("two states would be recorded in {}: rename {}", name, state->path()));
    writers_.emplace_back((std::filesystem::path(folder) / name).string());
    if (goes_on && keepInstants(writers_.back(), session.simulation().time()))
      last_step_ = session.simulation().steps();
  }
}

void Recorder::write() {
  Simulation& simulation = session_.simulation();
  if (last_step_ == simulation.steps()) return;
  last_step_ = simulation.steps();
  simulation.complete();
  for (std::size_t i = 0; i < states_.size(); ++i) {
    writers_[i].time(simulation.time());
    writers_[i].rows("X", states_[i]->x());
    writers_[i].rows("V", states_[i]->v());
  }
}

void Recorder::writeCheckpoint() { session_.writeCheckpoint(checkpoint_); }

void Recorder::finish() {
  write();
  for (StateWriter& writer : writers_) writer.close();
  writeCheckpoint();
}

std::vector<std::string> Recorder::files() const {
  std::vector<std::string> files;
  for (const StateWriter& writer : writers_) files.push_back(writer.path());
  files.push_back(checkpoint_);
  return files;
}

}  // namespace stroma::command
