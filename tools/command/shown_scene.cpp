// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/shown_scene.h"

#include <fmt/format.h>

#include <vector>

#include "tools/session/drop_readers.h"

namespace stroma::command {

void leaveOutputs(Simulation& simulation, const std::string& why) {
  std::vector<std::string> left;
  for (const Observer* observer : simulation.observers())
    if (!observer->files().empty()) left.push_back(observer->path());
  dropReaders(simulation);
  if (left.empty() || why.empty()) return;
  fmt::print(stderr, "note: {} write{} no file {}\n", fmt::join(left, ", "), left.size() == 1 ? "s" : "", why);
}

}  // namespace stroma::command
