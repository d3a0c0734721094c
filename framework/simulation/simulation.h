// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "framework/mechanics/history.h"
#include "framework/scene/archive.h"
#include "framework/scene/load.h"
#include "framework/simulation/integrator.h"
#include "framework/simulation/run_director.h"
#include "framework/simulation/run_edits.h"
#include "framework/simulation/run_inputs.h"
#include "framework/simulation/run_observers.h"
#include "framework/simulation/system_report.h"

namespace stroma {

/// A loaded scene that runs: systems in document order, then observers. It is used by one thread. Between two steps it may
/// be read, changed by the functions below, stored and restored. Its parts: RunClock (times), RunObservers, RunInputs
/// (external forces), RunEdits (attributes), RunLog (the record of changes), Snapshots (states to return to) and RunWatch
/// (signs of a wrong result).
class Simulation {
 public:
  /// Compiles the tree. Throws SceneError with every problem found.
  explicit Simulation(Scene scene);
  ~Simulation();

  double time() const { return clock_.time(); }
  double dt() const { return scene_.root->dt(); }
  long steps() const { return clock_.steps(); }
  Node& root() const { return *scene_.root; }
  const Scene& scene() const { return scene_; }
  /// Warnings and notes of the scene, for further checks.
  Diagnostics& diagnostics() { return scene_.diagnostics; }
  const Systems& systems() const { return systems_; }
  std::vector<State*> states() const;  ///< the states moved by a system, in document order
  const std::vector<Observer*>& observers() const { return observers_.all(); }
  /// Drops all observers, for runs that must not write files. Call it before begin().
  void dropObservers() { observers_.clear(); }

  /// Adds an observer. It sees the end of each step, and the present state in begin() if the run has already begun. Not
  /// owned: remove it, or let it outlive the simulation. Throws ComponentError if it cannot observe this scene.
  void addObserver(Observer& observer) { observers_.add(observer); }
  /// Removes an observer, after its end() if the run has begun. No effect if it was not added.
  void removeObserver(Observer& observer) { observers_.remove(observer); }

  /// Checks whether all observers could write their files now. Throws SceneError listing every file that could not be
  /// written; writes nothing.
  void checkOutputs() const { observers_.checkOutputs(); }
  /// Shows observers t = 0. The first step calls it if the caller has not. Throws OutputError if one of their files
  /// cannot be written; no file has then changed, unless the disk is full.
  void begin() { observers_.begin(); }
  /// Makes one step. If it diverges, or is stopped before its end, the states and the memory of integrators are those of the
  /// last successful step, and the report says why.
  /// Throws OutputError after the step if an observer cannot write; all others have then seen the step. An exception of
  /// a director comes before the step, which is then not made.
  StepReport step(StopToken stop = {});
  /// Some integrators compute nodes that nobody reads on demand only. Off (the default): every step ends with
  /// complete(). On: the caller calls complete() before reading x or v after a step; for observers this is automatic.
  void computeOnDemand(bool on) { observers_.computeOnDemand(on); }
  /// Brings every node up to date.
  void complete() const { stroma::complete(systems_); }
  /// Shows observers the end. Throws OutputError if one cannot write; all others have then ended.
  void end() { observers_.end(); }
  /// Returns to the initial state, bit for bit.
  void reset();

  /// The complete state of the run: x, v, time, the data of every component (Component::serialize()), inputs and edits. A run
  /// restored in this scene, loaded by the same build, continues with the same bits as an uninterrupted one.
  Archive checkpoint();
  /// Throws std::runtime_error if the values belong to another scene; this simulation is then unchanged, with its
  /// attributes, inputs, times and counts, or the message says that it could not be restored. Observers end, and
  /// begin again with the next step; simulation.steps() > 0 tells them that the run continues.
  void restore(Archive checkpoint);
  /// Replaces this scene by the same one with other meshes, and continues the run from `values`, a checkpoint of it.
  /// Observers end and begin again; dropped ones stay dropped. reset() brings the first scene back. Throws what
  /// restore() throws, and then nothing has changed.
  void become(std::unique_ptr<Simulation> changed, Archive values);
  bool hasChangedMeshes() const { return first_ != nullptr; }  ///< since the start of the run
  /// The scene before its meshes changed, for its description and its edits; null: they have not changed.
  const Simulation* first() const { return first_.get(); }

  /// Changes an attribute of a running scene as declared: at once, or by recreating the component. `path` names a component
  /// or a node (gravity, dt). The next step uses the new value; x, v and histories stay. Throws ComponentError if the
  /// change needs a restart, affects something that an integrator has precomputed, or is not allowed by the attribute.
  /// Nothing has changed then, whatever was thrown on the way. Returns warnings and
  /// notes. reset() keeps the new value.
  Diagnostics setAttribute(const std::string& path, const std::string& attribute, const std::string& text) {
    return edits_.set(path, attribute, text);
  }
  /// The changes made this way, each attribute once, in the order of the last changes.
  std::vector<Override> edits() const { return edits_.all(); }
  /// The attributes of the scene as loaded.
  void takeEditsBack() { edits_.takeBack(); }

  // ---- external forces, between steps ----
  /// Adds an input that acts from the next step until it is removed; returns its number. Throws ComponentError for an
  /// unknown state or node, a mapped state, and nodes inside a condensed body or a ball on one.
  long addInput(const Input& input) { return inputs_.add(input); }
  /// Replaces the input with this number, as when a handle moves.
  void changeInput(long number, const Input& input) { inputs_.change(number, input); }
  void removeInput(long number) { inputs_.remove(number); }

  // ---- positions and velocities from outside, between steps ----
  /// Sets rows of x and v of `state`, all of them; empty lists leave them unchanged. Constrained rows stay in place, and
  /// mapped states follow. Integrators and linear solvers restart as at the beginning of a run; histories keep their
  /// data, as if the body had moved in no time. Returns the number of rows that constraints kept from their new positions.
  /// Throws ComponentError, and changes nothing, during a step, and for non-finite numbers, a mapped state, a state moved
  /// by a precomputed matrix, and bodies that would overlap.
  Index setState(const State& state, ConstRows x, ConstRows v);
  /// A step is in progress: nothing may be changed.
  bool isStepping() const { return stepping_; }

  // ---- the record of all changes from outside: inputs and attributes ----
  /// All changes since the start of the run, in order: applied again to the same scene, as loaded, they repeat the run bit
  /// for bit. Rejected changes are not included. Of several targets, forces or balls of one input before the same step
  /// only the last is kept. After reset() the record starts with the remaining edits, at step 0. After restore() it starts
  /// with those of the checkpoint, edits at step 0 and inputs at its step: it repeats the rest in the same scene, restored
  /// from the same checkpoint.
  const std::vector<RunEvent>& events() const { return log_.events(); }
  /// Throws ComponentError if the event is impossible in any state of the scene.
  void check(const RunEvent& event) const;
  /// Applies it now. An input that has already ended may end again.
  void make(const RunEvent& event);
  /// Sets the director that applies events before the steps; null: none.
  void setDirector(std::unique_ptr<RunDirector> director);
  RunDirector* director() const { return director_.get(); }

  /// A 64-bit hash over the bits of all x and v, independent of the number of threads.
  std::uint64_t stateHash() const;
  // ---- for checks of the result ----
  const Snapshots& snapshots() const { return snapshots_; }
  const RunWatch& watch() const { return watch_; }

 private:
  void serialize(Archive& archive);
  void take(Archive values);
  void swapScene(Simulation& other);
  void becomeFirst();
  /// The initial state, and nothing else.
  void forget();
  StepReport makeStep(StopToken stop);
  /// One step of system `index`; if it fails, all systems up to it are restored.
  void advance(std::size_t index, const StepContext& context, StepReport& report);
  void takeBack(std::size_t failed);
  /// The system restores its own step, and no other has to.
  bool isLean(std::size_t index) const { return systems_.size() == 1 && systems_[index]->integrator().stateOwner(); }
  /// Accepts the step for `history`; if it reports a fault, a static step is unsolved.
  void endHistory(History& history, const StepContext& context, StepReport& report) const;

  /// Owns the tree that all pointers of the systems refer to.
  Scene scene_;
  Systems systems_;
  std::vector<History*> histories_;
  std::vector<FaultWatch> fault_watches_;  ///< per system
  RunClock clock_;
  Snapshots snapshots_;
  RunWatch watch_;
  RunLog log_;
  RunObservers observers_{*this, systems_};
  RunInputs inputs_;
  RunEdits edits_;
  std::unique_ptr<RunDirector> director_;
  std::unique_ptr<Simulation> first_;  ///< holds the scene before become()
  bool stepping_ = false;
};

}  // namespace stroma
