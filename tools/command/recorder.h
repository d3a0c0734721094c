// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "framework/simulation/state_file.h"
#include "tools/session/session.h"

namespace stroma::command {

/// What a Recorder writes in `folder`: a file for each state and for each component that computes something for its nodes, and the
/// checkpoint. Throws std::runtime_error when two would share a file.
std::vector<std::string> recordedFiles(const Simulation& simulation, const std::string& folder);

/// A checkpoint of each instant from which on the meshes are others: the files in the folder, in their order.
std::vector<std::string> meshFilesIn(const std::string& folder);

/// Writes positions and velocities of every state to one file each in `folder`, what components compute for nodes, and a
/// checkpoint: now and then, of the end, and where meshes have changed. Throws OutputError; a file that cannot be written does not keep the
/// others from what they have to write.
class Recorder {
 public:
  /// Opens the files; instants are recorded every `every` steps.
  Recorder(Session& session, const std::string& folder, long every);
  /// A run from the start: a checkpoint of a run before must not be taken for one of this run.
  void dropCheckpoint();
  /// A run that goes on from a checkpoint: instants up to there that the files hold are kept.
  void goOn();
  /// The present instant when its turn has come, or nothing has been recorded yet.
  void write();
  /// In place of the one before.
  void writeCheckpoint();
  /// The last instant, the checkpoint, and the ends of the files. `is_whole` false: some output lacks what it should
  /// have; the checkpoint before, where nothing was missing, is left as it is.
  void finish(bool is_whole = true);
  /// Those that are there.
  std::vector<std::string> files() const;

 private:
  /// Of a file; null: it is that of a component.
  State* stateOf(std::size_t file) const { return file < states_.size() ? states_[file] : nullptr; }
  void record();
  void writeMeshes();
  void dropMeshesAfter(long step) const;
  bool hasPresentMeshes() const;
  void takeOver();
  template <class Act>
  void forEachWriter(Act&& act);

  Session& session_;
  long every_;
  std::vector<State*> states_;
  std::vector<std::string> components_;  ///< paths; their files come after those of the states
  std::vector<StateWriter> writers_;
  std::string folder_, checkpoint_;  ///< folder and file
  long last_step_ = -1, meshes_ = -1;  ///< meshes: Session::meshChanges() when they were written last
  bool is_empty_ = true;  ///< nothing has been recorded
};

}  // namespace stroma::command
