// SPDX-License-Identifier: LGPL-2.1-or-later
// A scene that is loaded and run by a program: what commands, a viewer, a Python module or a sweep share.
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

/// When a run ends; whichever comes first.
struct RunLimits {
  long steps = std::numeric_limits<long>::max();     ///< made by this call
  std::optional<double> until{};                     ///< time of the simulation [s]: the first step that reaches it
  std::function<bool(const Simulation&)> reached{};  ///< asked after each step
  /// Called before each step, when everything that may be done between steps may be done. What it throws ends the run.
  std::function<void(Simulation&)> before_step{};
  /// Told after each good step: its report and its wall time [s].
  std::function<void(const StepReport&, double)> after_step{};
};

enum class RunEnd {
  done,           ///< a limit was reached
  stopped,        ///< requestStop(): the state is that after the last whole step
  diverged,       ///< the state is that before the step that failed
  mesh_refused,   ///< a mesh was to change and could not: the state is that before the step
  not_converged,  ///< no equilibrium, or a position constraint that does not hold: the state is no result
  not_replayed,   ///< an event of a replay was refused: the state is that before its step
  program_failed,  ///< the scene's own program: the state is that of the last whole step
  output_failed,  ///< an observer, or what is told after each step, could not write; all others have seen the step
};

/// How a run ended. Nothing is printed.
struct RunReport {
  RunEnd end = RunEnd::done;
  StepReport last;           ///< of the last step
  std::string reason;        ///< a sentence, unless done or stopped
  double seconds = 0;        ///< wall time
  RunStatistics statistics;  ///< of this call; what is unconverged is that of the session's run
};

/// Modules, a loaded scene and its simulation. Who holds shared() keeps the simulation as it is when the session drops it or
/// loads another scene; the code of components stays until the process ends.
///
/// Threads: one thread at a time uses a session and what belongs to it (simulation, states, observers), and only between
/// steps; observers are called by the thread that steps. requestStop() alone may be called by any thread, or a signal
/// handler, at any time: the run ends at once, a long step under way is given up, and then another thread may take over. Two sessions may
/// run in two threads. setThreads() is of the process and comes before any of them steps.
class Session {
 public:
  Session() = default;
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  Factory& factory() { return factory_; }
  Modules& modules() { return modules_; }
  /// Overrides of every scene that is loaded from now on.
  void setOverrides(std::vector<Override> overrides) { overrides_ = std::move(overrides); }

  /// Loads a scene and compiles it, in place of the one before. Throws SceneError with every problem found; the session
  /// then holds no scene. Warnings and notes are in simulation().scene().diagnostics.
  Simulation& load(const std::string& scene_file, const std::vector<Override>& more_overrides = {});
  /// The same from XML text; `name` stands for the file in messages, and relative file names start at its folder.
  Simulation& loadText(const std::string& xml, const std::string& name,
                       const std::vector<Override>& more_overrides = {});
  /// The same from a description that a program made or keeps. `diagnostics`: what was found when it was read.
  Simulation& load(SceneDescription description, const std::vector<Override>& more_overrides = {},
                   Diagnostics diagnostics = {});
  /// A scene file with its includes and overrides: what load() makes a scene of. Problems go to `diagnostics`; throws
  /// SceneError when there is no tree.
  SceneDescription read(const std::string& scene_file, const std::vector<Override>& more_overrides,
                        Diagnostics& diagnostics);
  /// Ends observers and drops the scene.
  void unload();
  bool isLoaded() const { return simulation_ != nullptr; }
  /// Throws std::logic_error when nothing is loaded.
  Simulation& simulation() const;
  /// The same, owned together with the session; null when nothing is loaded.
  std::shared_ptr<Simulation> shared() const { return simulation_; }
  const std::string& sceneFile() const { return scene_file_; }

  /// Steps until a limit, a stop, or a step without a result. Observers see the start first; they see the end when
  /// finish() is called. Run again to go on.
  RunReport run(const RunLimits& limits);
  /// One step of the simulation, in which a scene that is a program takes part. Throws ProgramError.
  StepReport step(StopToken stop = {});
  /// From now on meshes may change at the start of steps (tools/session/mesh_changes.h): who holds on to states or components of the
  /// scene beyond a step must look them up again; `changed` is called when they are others, before the step is made. Else a step
  /// in which a mesh would change is refused.
  void followMeshChanges(std::function<void(const NodesNow&)> changed = {}) {
    follows_mesh_changes_ = true, mesh_changed_ = std::move(changed);
  }
  /// A mesh changes now, between two steps: for a program that leads the run. `who` is named where it cannot. Returns what is left to
  /// say. Throws ComponentError; nothing has changed then.
  std::vector<std::string> changeMesh(MeshChange change, const std::string& who);
  /// How often steps, changeMesh() and restore() have made other states: who asks again knows whether they have since.
  /// Simulation::reset() is not counted: who calls it knows.
  long meshChanges() const { return mesh_changes_; }
  /// What such changes have left to say, each component once.
  const std::vector<std::string>& meshNotes() const { return mesh_notes_; }
  /// Whether the scene is a program, which hears keys.
  bool isProgram() const { return program_ != nullptr; }
  /// A key or the pointer of who shows the run, between steps; without effect on a scene that is no program. Both throw
  /// ProgramError.
  void key(const std::string& name, bool pressed);
  void mouse(const Mouse& mouse);
  /// How many steps it takes to `t` [s] with the present dt. Throws std::invalid_argument when that lies before the
  /// present, or too far.
  long stepsUntil(double t) const;
  /// From any thread: run() ends with the last whole step, or at once when it is called next.
  void requestStop() { stop_.make(); }
  /// A stop that nobody has heeded yet is not wanted any more.
  void withdrawStop() { stop_.take(); }
  /// Observers see the end: their files are whole.
  void finish() { simulation().end(); }

  /// With it goes which steps so far relied on solves that did not converge.
  void writeCheckpoint(const std::string& path) { checkpoint().write(path); }
  Checkpoint checkpoint();
  /// Restores a checkpoint of this scene. Returns notes: that another build or another file wrote it. Throws
  /// std::runtime_error with a sentence.
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
  UnconvergedSteps unconverged_;  ///< since the scene was loaded, or before the checkpoint
  StopRequest stop_;
  bool follows_mesh_changes_ = false;
  std::function<void(const NodesNow&)> mesh_changed_;
  std::vector<std::string> mesh_notes_;
  long mesh_changes_ = 0;
  bool mesh_refused_ = false;  ///< in the last step
  SceneProgram* program_ = nullptr;  ///< the scene is one, and takes part in its steps
};

}  // namespace stroma
