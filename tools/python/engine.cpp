// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/python/engine.h"

#include <fmt/format.h>

#include "tools/python/termination.h"
#include "tools/session/drop_readers.h"

namespace stroma::python {
namespace {

/// As long as it lives, this thread does not have the interpreter's lock, but in call(). What is quicker than
/// gil_scoped_acquire: the thread has a state already.
class Unlocked {
 public:
  ~Unlocked() { PyEval_RestoreThread(state_); }
  Unlocked() = default;
  Unlocked(const Unlocked&) = delete;

  /// Calls the functions, in their order and as long as there are some, with the lock. By the same thread.
  void call(const py::list& functions, const py::object& owner) {
    PyEval_RestoreThread(state_);
    struct Again {
      PyThreadState*& state;
      ~Again() { state = PyEval_SaveThread(); }
    } const again{state_};
    for (Py_ssize_t i = 0; i < PyList_GET_SIZE(functions.ptr()); ++i) {
      const auto function = py::reinterpret_borrow<py::object>(PyList_GET_ITEM(functions.ptr(), i));
      const auto result = py::reinterpret_steal<py::object>(PyObject_CallOneArg(function.ptr(), owner.ptr()));
      if (!result) throw py::error_already_set();
    }
  }

 private:
  PyThreadState* state_ = PyEval_SaveThread();
};

}  // namespace

std::vector<Override> overridesOf(const py::list& list) {
  std::vector<Override> out;
  for (const py::handle item : list) {
    const auto given = py::reinterpret_borrow<py::tuple>(item);
    out.push_back({given[0].cast<std::string>(), given[1].cast<std::string>(), textOf(given[2])});
  }
  return out;
}

Engine::~Engine() {
  if (last_solve_ && stepWatch() == last_solve_.get()) stepWatch() = nullptr;
  try {
    if (own_) own_->unload();
  } catch (const std::exception& error) {  // an observer could not write its end
    py::gil_scoped_acquire lock;
    PyErr_WarnEx(PyExc_RuntimeWarning, error.what(), 1);
    PyErr_Clear();
  }
}

void Engine::load(Diagnostics diagnostics, bool observed) {
  const EndingSignals signals;
  py::gil_scoped_release unlocked;
  session_.followMeshChanges([this](const NodesNow&) { meshChanged(); });
  session_.load(source_, overrides_, std::move(diagnostics));
  simulation_ = session_.shared();
  if (!observed) dropReaders(*simulation_);
}

/// States are others, and those that a program has placed start where the scene says: they go where they were put. Called before a
/// step, without the interpreter's lock.
void Engine::meshChanged() {
  for (const auto& [path, places] : placed_)
    if (auto* state = dynamic_cast<State*>(findComponent(simulation_->root(), path)); state && state->position.size() == places.size())
      state->position = places;
  if (keeps_forces_)
    for (State* state : simulation_->states()) state->requestForce();
  forcesAreOld();
}

std::vector<std::string> Engine::changeMesh(const std::string& path, MeshChange change) {
  between();
  change.topology = dynamic_cast<const Topology*>(&component(path));
  if (!change.topology) throw ComponentError(path + " is no mesh", "a container of cells");
  std::vector<std::string> notes = session_.changeMesh(std::move(change), path);
  if (!own_) meshChanged();  // the session tells who shows it
  return notes;
}

void Engine::placeStill(const std::string& path, std::vector<Vec3> places) {
  for (std::size_t i = 0; i < places.size(); ++i)
    if (const Vec3& x = places[i]; !x.allFinite())
      throw ComponentError(fmt::format("{}.position: node {} is put at ({}, {}, {})", path, i, x[0], x[1], x[2]), "finite numbers");
  dynamic_cast<State&>(component(path)).position = places;
  placed_[path] = std::move(places);
  forcesAreOld();
}

/// Whoever holds arrays of the first mesh learns it once.
void Engine::tellOfOldArrays() {
  constexpr long own_holders = 2;  // the session and this
  if (told_of_old_arrays_ || !simulation_->hasChangedMeshes() || simulation_.use_count() <= own_holders) return;
  told_of_old_arrays_ = true;
  if (PyErr_WarnEx(PyExc_RuntimeWarning,
                   "a mesh has changed: arrays taken of a state before (x, v, f) are of the mesh before, and follow the steps no "
                   "more. Take them again after each run",
                   1) != 0)
    throw py::error_already_set();
}

std::shared_ptr<Engine> Engine::ofFile(const std::string& file, const std::vector<Override>& overrides, bool observed) {
  auto engine = std::make_shared<Engine>();
  Diagnostics diagnostics;
  engine->source_ = engine->session_.read(file, overrides, diagnostics);
  engine->overrides_ = overrides;
  engine->load(std::move(diagnostics), observed);
  return engine;
}

std::shared_ptr<Engine> Engine::ofTree(const py::tuple& root, const std::string& file,
                                       const std::vector<Override>& overrides, bool observed) {
  auto engine = std::make_shared<Engine>();
  engine->source_ = descriptionOf(root, file);
  engine->overrides_ = overrides;
  engine->load({}, observed);
  return engine;
}

std::shared_ptr<Engine> Engine::copy() {
  between();
  if (!own_) throw std::runtime_error("a scene that the command runs cannot be copied: load it in a program");
  auto other = std::make_shared<Engine>();
  other->source_ = source_;
  other->overrides_ = overrides_;
  other->load({}, false);
  if (keeps_forces_) other->requestForces();
  other->restore(checkpoint());
  for (const auto& [path, places] : placed_) other->placeStill(path, places);
  return other;
}

Engine& Engine::twin() {
  between();
  if (twin_) {
    twin_->restore(checkpoint());
    for (const auto& [path, places] : placed_) twin_->placeStill(path, places);
  } else {
    twin_ = copy();
  }
  return *twin_;
}

void Engine::reset() {
  between().reset();
  restored_.clear();
  forcesAreOld();
}

Simulation& Engine::use() const {
  const std::thread::id user = user_;
  if (user != std::thread::id() && user != std::this_thread::get_id())
    throw std::runtime_error("another thread is stepping this simulation: wait for it, or use a simulation of its own");
  return *simulation_;
}

Simulation& Engine::between() const {
  if (use().isStepping()) throw std::runtime_error("a step is under way: this can be done between two steps");
  return *simulation_;
}

Component& Engine::component(const std::string& path) const {
  if (Component* found = findComponent(simulation_->root(), path)) return *found;
  std::vector<Component*> all;
  simulation_->root().collect(all);
  std::vector<std::string> paths;
  for (const Component* each : all) paths.push_back(each->path());
  throw ComponentError("the scene has no component " + path, "a path of the scene", nearest(path, paths));
}

RunReport Engine::run(std::optional<long> steps, std::optional<double> until, const py::list& begin, const py::list& end,
                      const py::object& owner, bool heeds_interrupts) {
  if (use().isStepping() || user_.load() != std::thread::id())
    throw std::runtime_error("a step is under way: it ends before another one begins");
  RunLimits limits;
  if (steps) limits.steps = *steps;
  limits.until = until;
  Unlocked* unlocked = nullptr;
  if (begin.size() > 0) limits.before_step = [&](Simulation&) { unlocked->call(begin, owner); };
  if (end.size() > 0) limits.after_step = [&](const StepReport&, double) { unlocked->call(end, owner); };
  limits.reached = [this](const Simulation&) { return is_enough_.exchange(false); };
  is_enough_ = false;
  const InUse used(*this);
  const LastSolve::Watching watching(last_solve_.get());
  RunReport report;
  {
    const EndingSignals signals(&session_, heeds_interrupts);
    Unlocked without_lock;
    unlocked = &without_lock;
    try {
      report = session_.run(limits);
    } catch (...) {
      forcesAreOld();
      session_.withdrawStop();  // the signal has become an exception of a function of the program
      throw;
    }
  }
  if (report.end != RunEnd::done) forcesAreOld();  // a step may have been given up
  if (PyErr_CheckSignals() != 0) {
    session_.withdrawStop();  // of a signal that came when the run had ended
    throw py::error_already_set();
  }
  tellOfOldArrays();
  return report;
}

}  // namespace stroma::python
