// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <map>
#include <string>
#include <vector>

#include "tools/command/instants.h"
#include "tools/command/last_folder.h"
#include "tools/command/run_request.h"

namespace stroma::command {

/// "results/organ/last", below the current folder, for scenes/organ.xml.
std::string lastFolder(const std::string& scene);
/// What a run leaves there.
std::vector<std::string> lastFiles(const std::string& scene);

/// What a run without --record leaves to be looked at: the first instant, the last, and some twenty between, with a
/// checkpoint. It replaces that of the run before, and nothing else.
///
/// Instants are kept in memory and written every minute and when the run ends. A run that is killed leaves those of its
/// last whole minute, or what the run before has left. Of two runs at once one is left whole.
class DefaultRecording {
 public:
  /// `steps`: number of the last one. Nothing is written yet.
  DefaultRecording(Session& session, const RunRequest& request, long steps);
  void begin();
  void stepMade(const StepReport& report, double seconds) {
    if (simulation_.steps() >= next_) keep();
    seconds_ += seconds;
    if (seconds_ >= write_every_ && report.constraints_converged) writeMeanwhile();
  }
  /// The last instant, and all files. `is_needed`: the run has no result, and its last state is written however large
  /// it is. `may_go_on`: a run may go on from it, with a checkpoint. False when nothing was written: see reason().
  bool write(bool is_needed, bool may_go_on);

  const std::string& folder() const { return folder_; }
  std::vector<std::string> files() const;  ///< that were written
  std::size_t instants() const { return kept_.size(); }
  const std::string& reason() const { return reason_; }  ///< a sentence on why nothing was written, or empty
  /// What is there although write() could not: "", or a sentence that follows reason().
  std::string rest() const;

 private:
  /// Beside them there is room for the last instant. Even, so that every second one leaves even strides.
  long mostStrided() const { return (long(most_) - 1) / 2 * 2; }
  void keep();
  void append();
  void takeMeshes();
  std::size_t contentsBytes() const;
  std::vector<std::string_view> parts(std::string& head) const;
  void thin();
  void checkPlace();
  void putInPlace(bool with_checkpoint);
  void writeMeanwhile();

  Session& session_;
  const Simulation& simulation_;
  std::string folder_, reason_;
  std::vector<State*> states_;
  InstantsHead head_;
  std::string bytes_;  ///< of the instants
  std::size_t each_ = 0;  ///< of an instant, with the meshes that the scene was written with
  struct Kept {
    std::size_t bytes = 0;
    long meshes = 0;  ///< Session::meshChanges()
  };
  std::vector<Kept> kept_;  ///< instants
  struct Meshes {
    std::string bytes{};         ///< of a checkpoint
    std::vector<Index> nodes{};  ///< of each state
  };
  std::map<long, Meshes> meshes_;  ///< that kept instants are of, by their changes
  std::size_t most_ = 0;                   ///< instants that there is room for
  long every_ = 0, next_ = 0, last_ = -1;  ///< [steps]
  bool has_checkpoint_ = false, goes_on_in_place_ = false;
  std::optional<FileIdentity> own_checkpoint_;  ///< in the folder: that the run goes on from, or has written itself
  double write_every_ = 0, seconds_ = 0;        ///< of steps; since the files were written
  std::optional<double> written_time_;          ///< of the simulation, in the files [s]
};

}  // namespace stroma::command
