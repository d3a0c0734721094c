// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/recorder.h"

#include <fmt/format.h>

#include <filesystem>
#include <set>

#include "framework/mechanics/history_file.h"

namespace stroma::command {

Recorder::Recorder(const Simulation& simulation, const std::string& folder)
    : simulation_(simulation), folder_(folder), states_(simulation.states()) {
  std::set<std::string> names;
  for (const State* state : states_) {
    const std::string name = stateFileName(state->path());
    if (!names.insert(name).second)
      throw std::runtime_error(fmt::format("two states would be recorded in {}: rename {}", name, state->path()));
    writers_.emplace_back((std::filesystem::path(folder) / name).string());
  }
}

void Recorder::write() {
  if (last_step_ == simulation_.steps()) return;
  last_step_ = simulation_.steps();
  simulation_.complete();
  for (std::size_t i = 0; i < states_.size(); ++i) {
    writers_[i].time(simulation_.time());
    writers_[i].rows("X", states_[i]->x());
    writers_[i].rows("V", states_[i]->v());
  }
}

void Recorder::finish() {
  write();
  for (StateWriter& writer : writers_) writer.close();
  std::vector<Component*> components;
  simulation_.root().collect(components);
  for (const Component* component : components) {
    const auto* history = dynamic_cast<const History*>(component);
    if (!history || history->history().empty()) continue;
    histories_.push_back((std::filesystem::path(folder_) / historyFileName(component->path())).string());
    writeHistoryFile(histories_.back(), history->history());
  }
}

std::vector<std::string> Recorder::files() const {
  std::vector<std::string> files;
  for (const StateWriter& writer : writers_) files.push_back(writer.path());
  files.insert(files.end(), histories_.begin(), histories_.end());
  return files;
}

}  // namespace stroma::command
