// SPDX-License-Identifier: LGPL-2.1-or-later
// Loads and runs a scene. Shared by the command, the viewer, the Python module and sweeps.
#pragma once
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "framework/scene/modules.h"
#include "framework/simulation/mesh_changer.h"
#include "tools/session/checkpoint.h"
#include "tools/session/mesh_changes.h"
#include "tools/session/statistics.h"

namespace stroma {

class SceneProgram;
struct Mouse;

/// When a run ends, whichever comes first.
struct RunLimits {
  long steps = std::numeric_limits<long>::max();     ///< made by this call
  std::optional<double> until{};                     ///< simulation time [s]: the first step that reaches it
  std::function<bool(const Simulation&)> reached{};  ///< called after each step
  /// Called before each step, when any change between steps is allowed. An exception ends the run.
  std::function<void(Simulation&)> before_step{};
  /// Called after each successful step with its report and wall time [s].
  std::function<void(const StepReport&, double)> after_step{};
};

enum class RunEnd {
  done,           ///< a limit was reached
  stopped,        ///< requestStop(): the state is that after the last complete step
  diverged,       ///< the state is that before the failed step
  mesh_refused,   ///< a mesh change failed: the state is that before the step
  not_converged,  ///< no equilibrium, or a violated position constraint: the state is not a result
  not_replayed,   ///< a replayed event was rejected: the state is that before its step
  program_failed,  ///< the scene's own program failed: the state is that of the last complete step
  output_failed,  ///< an observer or the callback after a step could not write; all others have seen the step
};

/// How a run ended. Nothing is printed.
struct RunReport {
  RunEnd end = RunEnd::done;
  StepReport last;           ///< of the last step
  std::string reason;        ///< a sentence, unless done or stopped
  double seconds = 0;        ///< wall time
  RunStatistics statistics;  ///< of this call; unconverged steps are those of the whole run
};

/// Modules, a loaded scene and its simulation. A caller that holds shared() keeps the simulation when the session drops it or
/// loads another scene; the code of components stays loaded until the process ends.
///
/// Threads: a session and everything it owns (simulation, states, observers) is used by one thread at a time, and only between
/// steps; observers are called by the stepping thread. Only requestStop() may be called by any thread, or a signal handler, at
/// any time: the run then ends, abandoning a long step in progress, and another thread may take over. Two sessions may
/// run in two threads. The number of threads is process-wide: tools/session/thread_choice.h.
class Session {
 public:
  Session() = default;
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  Factory& factory() { return factory_; }
  Modules& modules() { return modules_; }
  /// Sets overrides for every scene loaded afterwards.
  void setOverrides(std::vector<Override> overrides) { overrides_ = std::move(overrides); }

  /// Loads and compiles a scene, replacing the previous one. Throws SceneError with every problem found; the session
  /// then holds no scene. Warnings and notes are in simulation().scene().diagnostics.
  Simulation& load(const std::string& scene_file, const std::vector<Override>& more_overrides = {});
  /// The same from XML text; `name` replaces the file name in messages, and its folder is the base of relative file names.
  Simulation& loadText(const std::string& xml, const std::string& name,
                       const std::vector<Override>& more_overrides = {});
  /// The same from a description. `diagnostics`: problems found when it was read.
  Simulation& load(SceneDescription description, const std::vector<Override>& more_overrides = {},
                   Diagnostics diagnostics = {});
  /// Reads a scene file with its includes and overrides, as load() does. Problems go to `diagnostics`; throws SceneError if
  /// there is no tree.
  SceneDescription read(const std::string& scene_file, const std::vector<Override>& more_overrides,
                        Diagnostics& diagnostics);
  /// Ends observers and drops the scene.
  void unload();
  bool isLoaded() const { return simulation_ != nullptr; }
  /// Throws std::logic_error if nothing is loaded.
  Simulation& simulation() const;
  /// The same, owned together with the session; null if nothing is loaded.
  std::shared_ptr<Simulation> shared() const { return simulation_; }
  const std::string& sceneFile() const { return scene_file_; }

  /// Steps until a limit, a stop, or a step without a result. Observers first see the start; they see the end when finish()
  /// is called. Call run() again to continue.
  RunReport run(const RunLimits& limits);
  /// One step of the simulation, with the scene's program if it has one. Throws ProgramError.
  StepReport step(StopToken stop = {});
  /// Allows meshes to change at the start of steps (tools/session/mesh_changes.h). Pointers to states and components are then
  /// valid for one step only; `changed` is called when they have been replaced, before the step is made. Without this call a
  /// step in which a mesh would change is an error.
  void followMeshChanges(std::function<void(const NodesNow&)> changed = {}) {
    follows_mesh_changes_ = true, mesh_changed_ = std::move(changed);
  }
  /// Changes a mesh now, between two steps, for a program that controls the run. `who` is named in errors. Returns notes. Throws
  /// ComponentError, and then nothing has changed.
  std::vector<std::string> changeMesh(MeshChange change, const std::string& who);
  /// A counter of state replacements by steps, changeMesh() and restore(), for callers that cache pointers. Simulation::reset() is
  /// not counted.
  long meshChanges() const { return mesh_changes_; }
  /// Notes about such changes, once per component.
  const std::vector<std::string>& meshNotes() const { return mesh_notes_; }
  /// Whether the scene is a program that handles keys.
  bool isProgram() const { return program_ != nullptr; }
  /// Passes on a key or pointer event between steps; no effect on a scene that is not a program. Both throw
  /// ProgramError.
  void key(const std::string& name, bool pressed);
  void mouse(const Mouse& mouse);
  /// The number of steps to `t` [s] with the current dt. Throws std::invalid_argument if `t` is in the past or too far
  /// ahead.
  long stepsUntil(double t) const;
  /// From any thread: run() ends after the last complete step, or immediately at its next call.
  void requestStop() { stop_.make(); }
  /// Withdraws a stop request that has had no effect yet.
  void withdrawStop() { stop_.take(); }
  /// Shows observers the end and completes their files.
  void finish() { simulation().end(); }

  /// Includes the record of steps that relied on unconverged solves.
  void writeCheckpoint(const std::string& path) { checkpoint().write(path); }
  Checkpoint checkpoint();
  /// Restores a checkpoint of this scene. Returns notes if another build or another file wrote it. Throws
  /// std::runtime_error.
  std::vector<std::string> restore(const std::string& path) { return restore(Checkpoint::read(path), path); }
  /// The same; `name` is for messages.
  std::vector<std::string> restore(Checkpoint checkpoint, const std::string& name);

 private:
  Simulation& take(const std::string& file, Scene scene);
  std::string changeMeshes();
  void restoreMeshes(Archive values);
  void meshesAreOthers();
  std::vector<Override> with(const std::vector<Override>& more_overrides) const;

  Factory factory_;
  Modules modules_{factory_};
  std::vector<Override> overrides_;
  std::string scene_file_;
  std::shared_ptr<Simulation> simulation_;
  UnconvergedSteps unconverged_;  ///< since the scene was loaded, including the time before a checkpoint
  StopRequest stop_;
  bool follows_mesh_changes_ = false;
  std::function<void(const NodesNow&)> mesh_changed_;
  std::vector<std::string> mesh_notes_;
  long mesh_changes_ = 0;
  bool mesh_refused_ = false;  ///< in the last step
  SceneProgram* program_ = nullptr;  ///< the scene's program, if it is one
};

}  // namespace stroma
