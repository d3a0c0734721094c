// SPDX-License-Identifier: LGPL-2.1-or-later
// What `stroma run` was asked for.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "tools/command/command.h"
#include "tools/command/options.h"
#include "tools/session/session.h"

namespace stroma::command {

struct RunRequest {
  std::string scene, record_folder, restart_file, replay_file, json_file;
  std::string profile_file;                     ///< of --profile
  std::string measure_file, measured_quantity;  ///< for `stroma sweep`
  std::vector<std::string> overrides, modules;  ///< as --set and --module had them; paths of modules are absolute
  std::optional<long> steps;
  std::optional<double> until;
  long record_every = 1, checkpoint_every = 0;  ///< [steps]; 0: never
  double checkpoint_seconds = 60;               ///< of wall time; 0: never
  bool quiet = false, strict = false, resume = false, no_record = false;

  explicit RunRequest(const Values& values);
  /// `stroma run SCENE`, without options.
  explicit RunRequest(std::string scene_file) : scene(std::move(scene_file)) {}
  /// Of the whole run, those before a checkpoint included.
  long stepsOf(const Session& session) const;
  bool recordsIn() const { return !record_folder.empty(); }
  /// Without an option a run leaves something to be looked at.
  bool leavesLast() const { return !recordsIn() && !no_record; }
  /// The checkpoint that the run goes on from, or empty.
  std::string checkpointToGoOnFrom() const;

 private:
  void readInterval(const Values& values, const std::string& option, long& interval) const;
};

/// Those of `stroma run`, without the scene's.
void addRunOptions(OptionList& options);
CommandLine runLine();

/// Empty when the user asked for help, and got it.
std::optional<Values> parseRunOptions(const Arguments& arguments);

/// What a run refuses between loading and its first step, which `stroma check` refuses too. Throws UsageError when the
/// run would write over what it reads, or one file twice, SceneError when observers cannot write, and OutputError when
/// it cannot write what the options name. Without such options nothing is written, and nothing has been when it throws.
void checkOutputs(const RunRequest& request, const Simulation& simulation);

}  // namespace stroma::command
