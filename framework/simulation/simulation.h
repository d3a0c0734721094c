// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "framework/mechanics/history.h"
#include "framework/scene/archive.h"
#include "framework/scene/live_edit.h"
#include "framework/scene/load.h"
#include "framework/simulation/integrator.h"
#include "framework/simulation/observer.h"
#include "framework/simulation/run_events.h"
#include "framework/simulation/system_report.h"

namespace stroma {

/// A loaded scene as it runs: systems in document order, observers after them. One thread uses it; between two steps it
/// may be read, changed by what is declared here, stored and restored.
class Simulation {
 public:
  /// Compiles the tree. Throws SceneError with every problem found.
  explicit Simulation(Scene scene);
  ~Simulation();

  double time() const { return time_; }
  double dt() const { return scene_.root->dt(); }
  long steps() const { return steps_; }
  Node& root() const { return *scene_.root; }
  const Scene& scene() const { return scene_; }
  const std::vector<std::unique_ptr<System>>& systems() const { return systems_; }
  std::vector<State*> states() const;  ///< those a system moves, in document order
  const std::vector<Observer*>& observers() const { return observers_; }
  /// From now on nothing observes: for runs that must not write files. Before begin().
  void dropObservers() { observers_.clear(); }

  /// From now on `observer` sees the end of each step, and first the present instant, by begin(), when the run has
  /// begun. Not owned: it must be removed, or outlive the simulation. Throws ComponentError when it cannot observe.
  void addObserver(Observer& observer);
  /// The observer sees its end() if the run has begun. No effect when it does not observe.
  void removeObserver(Observer& observer);

  /// Throws SceneError when files of observers could not be written as things stand, with every one of them and nothing
  /// written: what can be known of begin() before it.
  void checkOutputs() const;
  /// Observers see t = 0. Called by the first step when the caller has not. Throws OutputError when one of their files
  /// cannot be written; none has been changed then, unless a disk is full.
  void begin();
  /// One step. When it diverges, the states and what integrators remember are those of the last good step, and the
  /// report says why.
  /// Throws OutputError after the step when an observer cannot write; all others have seen the step then. Throws
  /// ReplayError before the step, which is not made, when an event of replay() is refused.
  /// A step that is asked to stop before its end is taken back like one that diverges; the report says so.
  StepReport step(StopToken stop = {});
  /// Some integrators compute nodes that nobody reads only on demand. Off (the default): every step ends with
  /// complete(). On: who reads x or v after a step calls complete() before; observers have it done for them.
  void computeOnDemand(bool on) { on_demand_ = on; }
  /// Brings every node to the present.
  void complete() const;
  /// Observers see the end. Throws OutputError when one cannot write; all others have ended then.
  void end();
  /// Back to the initial state, bit for bit.
  void reset();

  /// Everything that the run remembers: x, v, time, what every component keeps (Component::serialize()), inputs and
  /// edits. Restored in this scene, loaded by the same build, the run goes on with the bits of one that never stopped.
  Archive checkpoint();
  /// Throws std::runtime_error when the values are those of another scene; this simulation is then where it was, with
  /// its attributes, inputs, times and counts, or the sentence says that it could not be put back. Observers end, and
  /// begin again with the next step: simulation.steps() > 0 tells them that the run goes on.
  void restore(Archive checkpoint);

  /// Changes an attribute while the scene runs, as it was declared: at once, or by making the component anew. `path`
  /// names a component or a node (gravity, dt). The next step has the new value; x, v and histories stay. What needs a
  /// restart, what an integrator has computed beforehand and what the attribute does not allow is refused: a
  /// ComponentError with a sentence, and nothing has changed, whatever was thrown on the way. Returns warnings and
  /// notes. reset() keeps the new value.
  Diagnostics setAttribute(const std::string& path, const std::string& attribute, const std::string& text);
  std::vector<Override> edits() const;  ///< what has been set so, each attribute once, in the order of the last changes

  // ---- forces from outside, between steps ----
  /// Acts from the next step on, until it is removed; returns its number. Throws ComponentError with a sentence: an
  /// unknown state or node, a state that follows another by a mapping, nodes inside a condensed body or a ball on one.
  long addInput(const Input& input);
  /// Another force, target or ball in the place of the one with this number: a handle that moves.
  void changeInput(long number, const Input& input);
  void removeInput(long number);

  // ---- all that was done to the run from outside: inputs and attributes ----
  /// What was done since the start of the run, in order: given to replay() of the same scene, as loaded, it repeats the
  /// run bit for bit. What was refused is not in it; of several targets, forces or balls of one input before the same step it
  /// has the last. After reset() it starts with the edits that stay, at step 0. After restore() it starts with what the
  /// checkpoint has, edits at step 0 and inputs at its step: it repeats what follows in the same scene, restored from
  /// the same checkpoint.
  const std::vector<RunEvent>& events() const { return events_; }
  /// From now on these happen, each before the step that it came before; those of steps already made do not. Ascending
  /// in `step`. reset() begins them again, with the edits of now. `file`: where they were read, for messages. Throws
  /// SceneError with what can be known to be wrong now; step() throws ReplayError for the rest.
  void replay(std::vector<RunEvent> events, const std::string& file = {});
  /// How many of them have happened, or belong to steps that were made before.
  std::size_t replayed() const { return next_replayed_; }

  /// A 64-bit hash over the bits of all x and v: the same for any number of threads.
  std::uint64_t stateHash() const;
  /// Why the present shapes may be no result: a sentence for each force field with elements that are flat or inverted
  /// (a body may come to rest so) or strained beyond its law, for each elastic body far larger than at rest, for an
  /// energy that came from nowhere, for velocities that change sign from step to step (from the 17th step on), for a
  /// mesh that has folded over itself where no force field looks at its volumes, and for what an integrator reports.
  std::vector<std::string> doubts() const;
  /// How many volume elements of the states that move have no volume left, and of how many.
  struct CellCount {
    std::size_t inverted = 0, all = 0;
  };
  CellCount invertedCells() const;
  /// The compiled plan in lines: what runs each step, how often, what was skipped and why.
  std::vector<std::string> explain() const;

 private:
  /// A sentence when a system with an integrator that keeps energy has much more than at the start, or empty.
  std::string gainedEnergy(std::size_t index) const;
  /// Every few steps of an integrator that keeps energy: whether the step has turned the velocities around.
  void watchReversals(std::size_t index, long step);
  std::string reversals(std::size_t index) const;
  /// Why a force that is a step late and an integrator do not go together, or empty.
  static std::string laggedForce(const ForceField& field, const Integrator& integrator);
  void serialize(Archive& archive);
  void take(Archive values);
  void serializeInputs(Archive& archive);
  void setInput(long number, const Input& input);
  void dropInputs();
  void record(InputChange change);
  void replayDue();
  void replayOne(const RunEvent& event);
  /// Throws ComponentError when it cannot be, whatever the scene will be like then.
  void checkReplay(const RunEvent& event) const;
  Problem replayProblem(std::size_t index, const ComponentError& error) const;
  long firstNumber() const;
  /// The edits that stood before those of a replay.
  void takeReplayedEditsBack();
  System& systemOf(const Input& input, State*& state) const;
  /// Throws ComponentError when an integrator that follows no changes has computed something of it.
  void checkEdit(const LiveEdit& edit) const;
  /// Makes an edit, or leaves everything as it was and throws.
  void change(LiveEdit& edit, const LiveEdit::Value& value, Diagnostics& messages);
  void takeEditsBack();
  void serializeEdits(Archive& archive);
  void forget();
  void compileObservers(Diagnostics& diagnostics);
  void watchFollowers();
  /// A change of dt: times of steps count on from here.
  void countFromHere() { base_time_ = time_, base_step_ = steps_; }
  /// Times of the step that comes.
  StepContext nextStep(StopToken stop) const;
  /// One step of system `index`; when it fails, all systems up to it are taken back.
  void advance(std::size_t index, const StepContext& context, StepReport& report);
  /// The step stands for `history`; its fault makes a step without time unsolved.
  void endHistory(History& history, const StepContext& context, StepReport& report) const;
  /// Keeps x and v of every system for takeBackState().
  void keepState();
  void takeBackState();
  /// x and v of the systems up to the one that failed, before the step.
  void takeBack(std::size_t failed);
  template <class Tell>
  void tellAll(Tell&& tell);
  /// Observers after a good step; their time is counted apart.
  void notify(const StepContext& context);

  /// Owns the tree that all pointers of the systems lead into.
  Scene scene_;
  std::vector<std::unique_ptr<System>> systems_;
  std::vector<Observer*> observers_;
  std::vector<History*> histories_;
  std::vector<std::pair<Vector, Vector>> initial_;  ///< x and v of each system at the start, for reset()
  std::vector<std::pair<Vector, Vector>> good_;     ///< x and v of each system before the step
  std::vector<FaultWatch> watches_;                 ///< of each system
  struct Reversals {
    bool turned = false;  ///< the first step of a look did
    int in_a_row = 0;     ///< looks, up to the last one, that saw velocities turn
  };
  std::vector<Reversals> reversals_;  ///< of each system
  double time_ = 0;
  long steps_ = 0;
  /// The time of step n is base_time_ + (n - base_step_) dt: the start, or where dt changed last.
  double base_time_ = 0;
  long base_step_ = 0;
  std::map<long, Input> inputs_;  ///< that act now, by number
  long next_input_ = 1;
  std::vector<RunEvent> events_, replay_;
  std::string replay_file_;
  std::size_t next_replayed_ = 0;
  struct Edit {
    std::string path, attribute, original, text;
    DataOrigin origin = DataOrigin::by_default;  ///< of `original`
  };
  /// One per attribute that has changed, in the order of their last changes: made anew in this order they leave the same
  /// values, also where one attribute follows another by a link.
  std::vector<Edit> edits_;
  std::optional<std::vector<Edit>> edits_before_replay_;  ///< when the replay has edits
  bool worked_on_ = false;                                ///< an edit or an input may have brought energy in
  bool begun_ = false;
  bool on_demand_ = false;
  bool watches_followers_ = false;  ///< an observer watches single nodes that passive mappings place
};

}  // namespace stroma
