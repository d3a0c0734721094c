// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "tools/command/instants.h"
#include "tools/command/run_request.h"

namespace stroma::command {

/// "organ.last", in the current folder, for scenes/organ.xml.
std::string lastFolder(const std::string& scene);
/// What a run leaves there.
std::vector<std::string> lastFiles(const std::string& scene);

/// What a run without --record leaves to be looked at: the first instant, the last, and some twenty between, with a
/// checkpoint. It replaces that of the run before, and nothing else.
///
/// Instants are kept in memory and written when the run ends. Steps wait for no disk, a run that is killed leaves what
/// the run before has left, and of two runs at once one is left whole.
class DefaultRecording {
 public:
  /// `steps`: number of the last one. Nothing is written yet.
  DefaultRecording(Session& session, const RunRequest& request, long steps);
  void begin();
  void stepMade() {
    if (simulation_.steps() >= next_) keep();
  }
  /// The last instant, and all files. `is_needed`: the run has no result, and its last state is written however large it
  /// is. `may_go_on`: a run may go on from it, with a checkpoint. False when there is nothing to look at: see reason().
  bool write(bool is_needed, bool may_go_on);

  const std::string& folder() const { return folder_; }
  std::vector<std::string> files() const;  ///< that were written
  std::size_t instants() const { return count_; }
  const std::string& reason() const { return reason_; }  ///< a sentence on why nothing was written, or empty

 private:
  /// Beside them there is room for the last instant. Even, so that every second one leaves even strides.
  long mostStrided() const { return (long(most_) - 1) / 2 * 2; }
  void keep();
  void thin();
  void checkPlace();

  Session& session_;
  const Simulation& simulation_;
  std::string folder_, reason_;
  std::vector<State*> states_;
  std::string bytes_;  ///< of the file
  std::size_t head_ = 0, each_ = 0, count_ = 0;
  std::size_t most_ = 0;                   ///< instants that there is room for
  long every_ = 0, next_ = 0, last_ = -1;  ///< [steps]
  bool has_checkpoint_ = false;
};

}  // namespace stroma::command
