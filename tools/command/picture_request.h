// SPDX-License-Identifier: LGPL-2.1-or-later
// What `stroma picture` was asked for.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "tools/command/options.h"
#include "tools/command/recorded_run.h"
#include "tools/picture/picture_maker.h"

namespace stroma::command {

/// A time that is to be drawn [s]: the first instant of a run that reaches it, the nearest of a recording.
struct AskedTime {
  enum class Kind { start, time, end } kind = Kind::end;
  double time = 0;
};

/// A picture or a film, of a run that is made for it or of a recording.
struct PictureCommand {
  std::string scene;             ///< its file
  std::string recording_folder;  ///< of the recording that was named in place of a scene; empty: the scene is run
  RecordedRun recorded{};        ///< the run of that recording
  std::string file;              ///< to write
  bool is_named = false;         ///< the user has named the file
  std::optional<long> steps{};
  std::optional<double> until{};  ///< [s]
  std::vector<AskedTime> at{};    ///< what a picture shows side by side; empty: the end
  bool animates = false;          ///< a film
  std::optional<long> every{};    ///< steps, or instants, from one frame to the next
  double fps = 20;                ///< frames a second
  bool anyway = false;            ///< a run without a result is drawn too
  std::string restart_file;       ///< a checkpoint that the run begins at; empty: none
  bool lists_fields = false;      ///< nothing is drawn
  bool quiet = false;
  picture::PictureRequest look{};

  /// Throws UsageError for what is missing, excludes each other or would have no effect.
  explicit PictureCommand(const Values& values);
  bool isRecording() const { return !recording_folder.empty(); }
};

CommandLine pictureLine();

/// Empty when the user asked for help, and got it.
std::optional<Values> parsePictureOptions(const Arguments& arguments);

/// Throws UsageError when the picture would be written over what it is made of, or, by its usual name, over a file that is no
/// picture of stroma; OutputError when it cannot be written. Nothing has been written then.
void checkOutputs(const PictureCommand& command, const Simulation& simulation);

}  // namespace stroma::command
