// SPDX-License-Identifier: LGPL-2.1-or-later
// A simulation as Python holds it.
#pragma once
#include <atomic>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "framework/simulation/mesh_changer.h"
#include "tools/python/last_solve.h"
#include "tools/python/python.h"
#include "tools/session/session.h"

namespace stroma::python {

/// A session with what it was loaded from. One thread at a time uses it: while a step or a run is under way without the
/// interpreter's lock, use() refuses all others.
class Engine {
 public:
  Engine() : own_(std::make_unique<Session>()), session_(*own_) { registerPlayed(session_.factory()); }
  /// Around a session that somebody else runs: the command, for a scene in Python.
  explicit Engine(Session& session) : session_(session), simulation_(session.shared()) {}
  ~Engine();
  Engine(const Engine&) = delete;

  static std::shared_ptr<Engine> ofFile(const std::string& file, const std::vector<Override>& overrides, bool observed);
  static std::shared_ptr<Engine> ofTree(const py::tuple& root, const std::string& file,
                                        const std::vector<Override>& overrides, bool observed);
  /// The same scene loaded again, at the present of this one; nothing observes it.
  std::shared_ptr<Engine> copy();
  /// A copy kept for questions whose answers would disturb this one; brought to the present by each call.
  Engine& twin();

  /// For everything but looking on. Throws std::runtime_error when another thread uses it.
  Simulation& use() const;
  /// The same for what may be done between two steps only.
  Simulation& between() const;
  Simulation& simulation() const { return *simulation_; }
  const std::shared_ptr<Simulation>& shared() const { return simulation_; }
  Session& session() { return session_; }
  /// Whether the session is its own, and can be copied.
  bool isOwn() const { return own_ != nullptr; }
  Component& component(const std::string& path) const;

  /// Steps end with an evaluation of the force on every state from now on.
  void requestForces();
  /// State::f of the present: that of the last step; where something else has changed the state since, a copy of the simulation
  /// computes it, so that no bit of this one changes.
  void presentForces();
  /// State::f is that of another state than the present one.
  void forcesAreOld() { old_at_ = simulation_->steps(); }

  /// Session::checkpoint() with the forces of the last step, and those of constraints, which not all components can tell again
  /// after restore().
  Checkpoint checkpoint();
  std::vector<std::string> restore(Checkpoint checkpoint);
  /// Forces of Lagrangian constraints in the last step on all rows of a system, before mapped states hand them up. Throws
  /// ComponentError where a component does not tell them.
  Vector constraintForces(std::size_t system) const;
  void reset();

  /// Ends at a limit; `begin` and `end` are called with `owner` before and after each step.
  RunReport run(std::optional<long> steps, std::optional<double> until, const py::list& begin, const py::list& end,
                const py::object& owner, bool heeds_interrupts);
  /// From now on the equations of the last step of each system are kept; `matrices`: also A, b and x.
  void watchSolves(bool matrices) {
    if (!last_solve_) last_solve_ = std::make_unique<LastSolve>();
    last_solve_->keeps_matrices = last_solve_->keeps_matrices || matrices;
  }
  /// Null: nobody has asked for them.
  LastSolve* lastSolve() const { return last_solve_.get(); }

  /// Changes a mesh at once: the scene goes on with the other one, and states and components are others.
  /// Returns what is left to say. Throws ComponentError; nothing has changed then.
  std::vector<std::string> changeMesh(const std::string& topology, MeshChange change);

  /// Where states are that nothing moves and that a scene has put elsewhere, by their paths; a copy has them there too.
  void placeStill(const std::string& path, std::vector<Vec3> places);

  /// A run that is under way ends with its present step.
  void endAfterStep() { is_enough_ = true; }

 private:
  void load(Diagnostics diagnostics, bool observed);
  void meshChanged();
  void tellOfOldArrays();

  std::unique_ptr<Session> own_;  ///< unless it is somebody else's
  Session& session_;
  std::shared_ptr<Simulation> simulation_;
  SceneDescription source_;
  std::vector<Override> overrides_;
  std::shared_ptr<Engine> twin_;
  std::map<std::string, std::vector<Vec3>> placed_;
  std::unique_ptr<LastSolve> last_solve_;
  std::vector<Vector> restored_;  ///< constraintForces() of a checkpoint, until something steps
  bool keeps_forces_ = false;     ///< requestForces()
  bool told_of_old_arrays_ = false;
  long old_at_ = 0;               ///< Simulation::steps() when State::f was last of another state; each step makes it anew
  friend class InUse;
  std::atomic<std::thread::id> user_{};  ///< the thread that steps it
  std::atomic<bool> is_enough_{false};
};

/// As long as it lives, this thread alone uses the engine; afterwards whoever did before.
class InUse {
 public:
  explicit InUse(Engine& engine) : user_(engine.user_), before_(user_.exchange(std::this_thread::get_id())) {
    engine.restored_.clear();
  }
  ~InUse() { user_ = before_; }
  InUse(const InUse&) = delete;

 private:
  std::atomic<std::thread::id>& user_;
  const std::thread::id before_;
};

/// Overrides as (path, attribute, text).
std::vector<Override> overridesOf(const py::list& list);

}  // namespace stroma::python
