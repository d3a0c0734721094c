// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "framework/simulation/session.h"
#include "framework/simulation/state_file.h"

namespace stroma::command {

/// Writes positions and velocities of every state to one file each in `folder`, and a checkpoint: now and then, and of
/// the end.
class Recorder {
 public:
  /// Opens the files; nothing has its final name before finish(). `goes_on`: the run started from a checkpoint, and
  /// instants up to there that the folder's files hold are kept.
  Recorder(Session& session, const std::string& folder, bool goes_on = false);
  /// The present instant, unless it has been written already.
  void write();
  /// The file `last.checkpoint`, in place of the one before.
  void writeCheckpoint();
  /// The last instant, the checkpoint and the final names.
  void finish();
  std::vector<std::string> files() const;

 private:
  Session& session_;
  std::string checkpoint_;  ///< file
  std::vector<State*> states_;
  std::vector<StateWriter> writers_;
  long last_step_ = -1;
};

}  // namespace stroma::command
