// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "framework/simulation/simulation.h"
#include "framework/simulation/state_file.h"

namespace stroma::command {

/// Writes positions and velocities of every state to one file each in `folder`, and at the end what components remember
/// (History) to one each.
class Recorder {
 public:
  /// Opens the files; nothing has its final name before finish().
  Recorder(const Simulation& simulation, const std::string& folder);
  /// The present instant, unless it has been written already.
  void write();
  /// The last instant, and the final names.
  void finish();
  std::vector<std::string> files() const;

 private:
  const Simulation& simulation_;
  std::string folder_;
  std::vector<State*> states_;
  std::vector<StateWriter> writers_;
  std::vector<std::string> histories_;  ///< files written
  long last_step_ = -1;
};

}  // namespace stroma::command
