// SPDX-License-Identifier: LGPL-2.1-or-later
// What a run has left, and how to look at it.
#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "framework/simulation/simulation.h"

namespace stroma::command {

struct Results {
  std::string recording;              ///< folder, or empty
  std::vector<std::string> files;     ///< of observers; of a series the collection alone
  std::vector<std::string> commands;  ///< that show the recording, and the files; those that work here

  nlohmann::ordered_json json() const;
  /// At most three lines on standard output.
  void print() const;
};

/// `recording`: a folder that `stroma view` opens, or empty.
Results resultsOf(const Simulation& simulation, const std::string& recording);

}  // namespace stroma::command
