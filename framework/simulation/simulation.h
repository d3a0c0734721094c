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

/// A loaded scene as it runs: systems in document order, observers after them. One thread uses it; between two steps it
/// may be read, changed by what is declared here, stored and restored. Its parts have names of their own: RunClock (times),
/// RunObservers, RunInputs (forces from outside), RunEdits (attributes), RunLog (all that was done), Snapshots (what it
/// may go back to) and RunWatch (what its steps have shown).
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
  /// Warnings and notes of the scene, for tools that check it further.
  Diagnostics& diagnostics() { return scene_.diagnostics; }
  const Systems& systems() const { return systems_; }
  std::vector<State*> states() const;  ///< those a system moves, in document order
  const std::vector<Observer*>& observers() const { return observers_.all(); }
  /// Drops all observers: for runs that must not write files. Before begin().
  void dropObservers() { observers_.clear(); }

  /// From now on `observer` sees the end of each step, and first the present instant, by begin(), when the run has
  /// begun. Not owned: it must be removed, or outlive the simulation. Throws ComponentError when it cannot observe.
  void addObserver(Observer& observer) { observers_.add(observer); }
  /// The observer sees its end() if the run has begun. No effect when it does not observe.
  void removeObserver(Observer& observer) { observers_.remove(observer); }

  /// Throws SceneError, listing all of them, if files of observers could not be written as things stand. Writes
  /// nothing: what can be known of begin() before it.
  void checkOutputs() const { observers_.checkOutputs(); }
  /// Observers see t = 0. Called by the first step when the caller has not. Throws OutputError when one of their files
  /// cannot be written; none has been changed then, unless a disk is full.
  void begin() { observers_.begin(); }
  /// One step. If it diverges, the states and the memory of integrators are those of the last good step, and the
  /// report says why. The same holds if it is asked to stop before its end.
  /// Throws OutputError after the step when an observer cannot write; all others have seen the step then. What
  /// a director throws is thrown before the step, which is not made.
  StepReport step(StopToken stop = {});
  /// Some integrators compute nodes that nobody reads only on demand. Off (the default): every step ends with
  /// complete(). On: call complete() before reading x or v after a step; for observers this is done automatically.
  void computeOnDemand(bool on) { observers_.computeOnDemand(on); }
  /// Brings every node up to date.
  void complete() const { stroma::complete(systems_); }
  /// Observers see the end. Throws OutputError when one cannot write; all others have ended then.
  void end() { observers_.end(); }
  /// Back to the initial state, bit for bit.
  void reset();

  /// Everything that the run remembers: x, v, time, what every component keeps (Component::serialize()), inputs and
  /// edits. Restored in this scene, loaded by the same build, the run goes on with the bits of one that never stopped.
  Archive checkpoint();
  /// Throws std::runtime_error when the values are those of another scene; this simulation is then where it was, with
  /// its attributes, inputs, times and counts, or the sentence says that it could not be put back. Observers end, and
  /// begin again with the next step: simulation.steps() > 0 tells them that the run goes on.
  void restore(Archive checkpoint);
  /// The same scene with other meshes takes the place of this one, and the run goes on from `values`, a checkpoint of it.
  /// Observers end and begin again; those that were dropped stay so. reset() brings the first scene back. Throws what
  /// restore() throws, and nothing has changed.
  void become(std::unique_ptr<Simulation> changed, Archive values);
  bool hasChangedMeshes() const { return first_ != nullptr; }  ///< since the start of the run
  /// The scene before its meshes changed, for its description and its edits; null: they have not.
  const Simulation* first() const { return first_.get(); }

  /// Changes an attribute while the scene runs, as it was declared: at once, or by recompiling the component. `path`
  /// names a component or a node (gravity, dt). The next step has the new value; x, v and histories stay. What needs a
  /// restart, what an integrator has precomputed and what the attribute does not allow is rejected: a
  /// ComponentError with a sentence, and nothing has changed, whatever was thrown on the way. Returns warnings and
  /// notes. reset() keeps the new value.
  Diagnostics setAttribute(const std::string& path, const std::string& attribute, const std::string& text) {
    return edits_.set(path, attribute, text);
  }
  /// What has been set so, each attribute once, in the order of the last changes.
  std::vector<Override> edits() const { return edits_.all(); }
  /// The attributes of the scene as it was loaded.
  void takeEditsBack() { edits_.takeBack(); }

  // ---- forces from outside, between steps ----
  /// Acts from the next step on, until it is removed; returns its number. Throws ComponentError with a sentence: an
  /// unknown state or node, a state that follows another by a mapping, nodes inside a condensed body or a ball on one.
  long addInput(const Input& input) { return inputs_.add(input); }
  /// Another force, target or ball in the place of the one with this number: a handle that moves.
  void changeInput(long number, const Input& input) { inputs_.change(number, input); }
  void removeInput(long number) { inputs_.remove(number); }

  // ---- positions and velocities from outside, between steps ----
  /// Rows of x and v of `state`, as many as it has; without data they stay. What constraints hold stays where it is, and
  /// mapped states follow. Integrators and linear solvers restart, as at the start of a run; histories keep what they
  /// remember, as if the body had been moved in no time. Returns how many rows constraints kept from where they were to be.
  /// Throws ComponentError, and nothing has changed: in the middle of a step, numbers that are not finite, a state that
  /// follows another or that is moved by a matrix computed beforehand, bodies that would overlap.
  Index setState(const State& state, ConstRows x, ConstRows v);
  /// A step is under way: nothing may be changed.
  bool isStepping() const { return stepping_; }

  // ---- all changes made to the run from outside: inputs and attributes ----
  /// What was done since the start of the run, in order: done again to the same scene, as loaded, it repeats the run bit
  /// for bit. What was refused is not in it; of several targets, forces or balls of one input before the same step it
  /// has the last. After reset() it starts with the edits that stay, at step 0. After restore() it starts with what the
  /// checkpoint has, edits at step 0 and inputs at its step: it repeats what follows in the same scene, restored from
  /// the same checkpoint.
  const std::vector<RunEvent>& events() const { return log_.events(); }
  /// Throws ComponentError if the event is invalid in any state of the scene.
  void check(const RunEvent& event) const;
  /// Does it now. An input that has ended already may end again.
  void make(const RunEvent& event);
  /// Sets the director, which is called before each step; null: none.
  void setDirector(std::unique_ptr<RunDirector> director);
  RunDirector* director() const { return director_.get(); }

  /// A 64-bit hash over the bits of all x and v: the same for any number of threads.
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
  /// One step of system `index`; when it fails, all systems up to it are taken back.
  void advance(std::size_t index, const StepContext& context, StepReport& report);
  void takeBack(std::size_t failed);
  /// The system puts its own step back, and no other has to.
  bool isLean(std::size_t index) const { return systems_.size() == 1 && systems_[index]->integrator().stateOwner(); }
  /// The step is final for `history`; its fault makes a static step unsolved.
  void endHistory(History& history, const StepContext& context, StepReport& report) const;

  /// Owns the tree that all pointers of the systems lead into.
  Scene scene_;
  Systems systems_;
  std::vector<History*> histories_;
  std::vector<FaultWatch> fault_watches_;  ///< of each system
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
