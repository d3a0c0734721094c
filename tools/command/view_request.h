// SPDX-License-Identifier: LGPL-2.1-or-later
// What `stroma view` was asked for.
#pragma once
#include <optional>
#include <string>

#include "tools/command/recorded_run.h"
#include "tools/view/viewer.h"

namespace stroma::command {

/// A run that is viewed, a recording that is viewed, or a page that is written of one of them.
struct ViewCommand {
  std::string scene;             ///< its file
  std::string recording_folder;  ///< of the recording that was named in place of a scene; empty: a scene is run
  RecordedRun recorded{};        ///< the run of that recording
  std::string record_folder, replay_file;
  long record_every = 1;       ///< [steps]
  bool exports = false;        ///< a page is written, nothing is served
  bool opens = false;          ///< the browser, at the address
  bool outputs = false;        ///< observers of the scene write their files
  bool quiet = false;          ///< no notes
  view::ViewRequest live{};    ///< without its recording and listeners
  view::ExportRequest page{};  ///< likewise

  /// Throws UsageError for what is missing, excludes each other or would have no effect.
  explicit ViewCommand(const Values& values);
  bool isRecording() const { return !recording_folder.empty(); }
  std::string actionsFile() const;  ///< what was done by hand, in the folder that is recorded in
};

CommandLine viewLine();

/// Empty when the user asked for help, and got it.
std::optional<Values> parseViewOptions(const Arguments& arguments);

/// Throws UsageError when the view would write over what it reads, or one file twice, SceneError when observers cannot
/// write, and OutputError when it cannot write what the options name. Nothing has been written then.
void checkOutputs(const ViewCommand& command, const Simulation& simulation);

}  // namespace stroma::command
