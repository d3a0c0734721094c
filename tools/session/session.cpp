// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/session/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "framework/scene/dialect.h"
#include "framework/scene/output_file.h"
#include "framework/scene/overrides.h"
#include "framework/scene/prefab.h"
#include "framework/scene/spans.h"
#include "framework/scene/written_units.h"
#include "tools/checks/beam_masses.h"
#include "tools/checks/cells_across.h"
#include "tools/checks/density_units.h"
#include "tools/checks/empty_selections.h"
#include "tools/checks/idle_parts.h"
#include "tools/checks/result_doubts.h"
#include "tools/checks/unit_doubts.h"
#include "tools/session/file_uses.h"
#include "tools/session/given_changes.h"
#include "tools/session/mesh_changes.h"
#include "tools/session/replay.h"
#include "tools/session/scene_program.h"
#include "tools/session/thread_choice.h"
#include "tools/units/unit_system.h"

namespace stroma {
namespace {

using Clock = std::chrono::steady_clock;
double secondsSince(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// Steps of dt from now to `until`; a step that round-off puts just short of it has reached it.
double stepsTo(double until, const Simulation& simulation) {
  return std::ceil((until - simulation.time()) / simulation.dt() - 1e-9);
}

/// A step without a result ends a run: every later one would start from it.
RunEnd endAfter(const StepReport& step) {
  return step.diverged ? RunEnd::diverged : step.constraints_converged ? RunEnd::done : RunEnd::not_converged;
}

/// What was found about a scene, with numbers in the units that it is written in.
Diagnostics inUnits(const Diagnostics& diagnostics, const UnitSystem& units) {
  Diagnostics renamed;
  for (Problem problem : diagnostics.problems()) {
    for (std::string* text : {&problem.message, &problem.expected, &problem.suggestion}) *text = units.sentence(*text);
    renamed.add(std::move(problem));
  }
  return renamed;
}

/// What the outermost node declares; else SI, as which every sentence is made.
UnitSystem declaredUnits(const NodeDescription& root) {
  const AttributeDescription* declared = root.find("units");
  const bool is_one = declared && !problemOfUnits(declared->value, root, true);
  return is_one ? readUnitSystem(declared->value) : readUnitSystem("m kg s");
}

/// Loads a scene; errors are reported in the units that its `root` declares.
template <class Load, class Root>
Simulation& toldInItsUnits(Load&& load, Root&& root) {
  try {
    return load();
  } catch (const SceneError& error) {
    throw SceneError(inUnits(error.diagnostics(), declaredUnits(root())));
  }
}

const std::string& reasonOf(const StepReport& step) {
  return step.diverged || step.unsolved || step.constraint_reason.empty() ? step.reason : step.constraint_reason;
}

}  // namespace

Simulation& Session::load(const std::string& scene_file, const std::vector<Override>& more_overrides) {
  unload();
  if (isSceneProgram(scene_file)) {
    SceneProgram& program = sceneProgram();
    Simulation& simulation = load(program.describe(scene_file, *this), more_overrides);
    program_ = &program;
    program.loaded(*this);
    return simulation;
  }
  const std::vector<Override> overrides = with(more_overrides);
  Diagnostics ignored;
  return toldInItsUnits([&]() -> Simulation& { return take(scene_file, loadScene(scene_file, overrides, factory_, modules_)); },
                        [&] { return readScene(scene_file, overrides, {}, ignored).root; });
}

Simulation& Session::loadText(const std::string& xml, const std::string& name,
                              const std::vector<Override>& more_overrides) {
  unload();
  Diagnostics ignored;
  return toldInItsUnits(
      [&]() -> Simulation& { return take(name, loadSceneText(xml, name, with(more_overrides), factory_, modules_)); },
      [&] { return readXml(xml, name, {}, ignored); });
}

Simulation& Session::load(SceneDescription description, const std::vector<Override>& more_overrides,
                          Diagnostics diagnostics) {
  unload();
  const std::vector<Override> overrides = with(more_overrides);
  std::vector<AttributeDescription>& attributes = description.root.attributes;
  if (isForeign(description.file, description.root, overrides) && !description.root.find(dialect_attribute))
    attributes.push_back({dialect_attribute, foreign_dialect, description.root.where});
  applyOverrides(overrides, description.root, diagnostics);
  const std::string file = description.file;
  NodeDescription declaring;
  declaring.attributes = attributes;
  const auto make = [&]() -> Simulation& {
    return take(file, instantiate(std::move(description), factory_, modules_, std::move(diagnostics)));
  };
  return toldInItsUnits(make, [&] { return declaring; });
}

SceneDescription Session::read(const std::string& scene_file, const std::vector<Override>& more_overrides,
                               Diagnostics& diagnostics) {
  SceneDescription description = readSceneWithPrefabs(scene_file, with(more_overrides), {},
                                                      knownTypes(factory_, modules_), diagnostics, nullptr);
  if (description.root.where.file.empty()) throw SceneError(std::move(diagnostics));
  return description;
}

std::vector<Override> Session::with(const std::vector<Override>& more_overrides) const {
  std::vector<Override> overrides = overrides_;
  overrides.insert(overrides.end(), more_overrides.begin(), more_overrides.end());
  return overrides;
}

Simulation& Session::take(const std::string& file, Scene scene) {
  scene_file_ = file;
  unconverged_ = {};
  mesh_notes_.clear();
  auto simulation = [&] {
    const Span span("compile");
    return std::make_shared<Simulation>(std::move(scene));
  }();
  const Span span("check the scene");
  Diagnostics& diagnostics = simulation->diagnostics();
  checkOverwriting(*simulation, diagnostics);
  refuseDensitiesOfOtherCells(simulation->scene(), diagnostics);
  if (diagnostics.hasErrors()) throw SceneError(std::move(diagnostics));
  warnOfEmptySelections(simulation->root(), diagnostics);
  warnOfIdleParts(*simulation, diagnostics);
  noteCoarseCells(*simulation, diagnostics);
  noteEqualMassesOfBeams(*simulation, diagnostics);
  diagnostics = inUnits(diagnostics, unitsOf(simulation->scene()));
  warnOfUnits(simulation->scene(), diagnostics);
  warnOfLaggedForces(*simulation, diagnostics);
  simulation_ = std::move(simulation);
  takeThreadsFor(*simulation_);
  return *simulation_;
}

void Session::unload() {
  if (simulation_) simulation_->end();
  simulation_.reset();
  program_ = nullptr;
}

Simulation& Session::simulation() const {
  if (!simulation_) throw std::logic_error("no scene is loaded");
  return *simulation_;
}

long Session::stepsUntil(double t) const {
  const double count = stepsTo(t, simulation());
  if (!(count >= 0 && count < 1e15))
    throw std::invalid_argument(fmt::format("expected a time from {} on", simulation().time()));
  return long(count);
}

/// A sentence when they cannot, or empty.
std::string Session::changeMeshes() {
  if (!follows_mesh_changes_) return {};
  Simulation& running = simulation();
  try {
    MeshChangesMade made = makeMeshChanges(running, factory_, modules_);
    for (std::string& note : made.notes) {
      const std::string path = note.substr(0, note.find_first_of(",:"));
      const auto is_of_it = [&path](const std::string& other) {
        return other.starts_with(path + ",") || other.starts_with(path + ":");
      };
      if (std::none_of(mesh_notes_.begin(), mesh_notes_.end(), is_of_it)) mesh_notes_.push_back(std::move(note));
    }
    if (made.any) ++mesh_changes_;
    if (made.any && mesh_changed_) mesh_changed_(made.nodes);
    return {};
  } catch (const ComponentError& error) {
    const std::string expected = error.expected.empty() ? "" : " (expected " + error.expected + ")";
    return fmt::format("step {} (from t = {:.6g} s): a planned change of a mesh is not possible: {}{}", running.steps() + 1, running.time(),
                       error.what(), expected);
  }
}

std::vector<std::string> Session::changeMesh(MeshChange change, const std::string& who) {
  if (!follows_mesh_changes_) throw ComponentError(who + " is to change, and what is done here needs the same mesh throughout");
  const MeshChangesMade made = makeGivenChanges(simulation(), factory_, modules_, {std::move(change)}, who);
  ++mesh_changes_;
  if (mesh_changed_) mesh_changed_(made.nodes);
  return made.notes;
}

StepReport Session::step(StopToken stop) {
  Simulation& running = simulation();
  takeThreadsFor(running);  // another session may have a number of its own
  mesh_refused_ = false;
  if (program_) {
    program_->beforeStep(running);
  } else {
    running.begin();
    // what a replay does before this step may move a region, and numbers nodes as they were then
    if (follows_mesh_changes_ && running.director()) running.director()->beforeStep(running);
  }
  StepReport report;
  report.reason = changeMeshes();
  mesh_refused_ = report.diverged = !report.reason.empty();
  if (!report.diverged) report = running.step(stop);
  if (program_ && !report.stopped && !report.diverged) program_->afterStep(running);
  return report;
}

void Session::key(const std::string& name, bool pressed) {
  if (program_) program_->key(name, pressed);
}

void Session::mouse(const Mouse& mouse) {
  if (program_) program_->mouse(mouse);
}

RunReport Session::run(const RunLimits& limits) {
  Simulation& running = simulation();
  const auto start = Clock::now();
  RunReport report;
  running.begin();
  for (long made = 0; made < limits.steps && report.end == RunEnd::done; ++made) {
    if (limits.until && !(stepsTo(*limits.until, running) > 0)) break;
    if (stop_.take()) {
      report.end = RunEnd::stopped;
      break;
    }
    if (limits.before_step) limits.before_step(running);
    try {
      const auto step_start = Clock::now();
      StepReport step = [&] {
        const Span span("whole step");
        return this->step(StopToken(stop_));
      }();
      if (step.stopped) break;
      report.last = std::move(step);
      report.end = mesh_refused_ ? RunEnd::mesh_refused : endAfter(report.last);
      if (report.last.diverged) break;
      const double seconds = secondsSince(step_start);
      report.statistics.add(report.last, seconds);
      unconverged_.add(report.last);
      if (limits.after_step) {
        const Span span("record and tell");
        limits.after_step(report.last, seconds);
      }
    } catch (const ReplayError& error) {
      report.end = RunEnd::not_replayed;
      report.reason = error.what();
      break;
    } catch (const ProgramError& error) {
      report.end = RunEnd::program_failed;
      report.reason = error.what();
      break;
    } catch (const OutputError& error) {
      report.end = RunEnd::output_failed;
      report.reason = error.what();
    }
    if (limits.reached && limits.reached(running)) break;
  }
  if (stop_.take() && report.end == RunEnd::done) report.end = RunEnd::stopped;
  if (report.end == RunEnd::done && report.last.unsolved) report.end = RunEnd::not_converged;
  if (report.end == RunEnd::diverged || report.end == RunEnd::not_converged || report.end == RunEnd::mesh_refused)
    report.reason = reasonOf(report.last);
  if (!report.reason.empty() && report.end != RunEnd::program_failed)
    report.reason = unitsOf(running.scene()).sentence(report.reason);
  report.statistics.unconverged = unconverged_;
  report.seconds = secondsSince(start);
  return report;
}

Checkpoint Session::checkpoint() {
  Checkpoint checkpoint{scene_file_, buildIdentity(), simulation().checkpoint()};
  checkpoint.values.enter("run");
  unconverged_.serialize(checkpoint.values);
  writeChangedScene(simulation(), checkpoint.values);
  return checkpoint;
}

/// Simulation::restore(), in the meshes that the values are of.
void Session::restoreMeshes(Archive values) {
  Simulation& running = simulation();
  Archive scene = values.take(changed_scene_owner);
  if (scene.entries().empty() && !running.hasChangedMeshes()) return running.restore(std::move(values));
  Archive before = running.checkpoint(), scene_before;
  writeChangedScene(running, scene_before);
  try {
    takeChangedScene(running, std::move(scene), factory_, modules_);
    running.restore(std::move(values));
  } catch (const std::exception& error) {
    const std::string why = error.what();
    takeChangedScene(running, scene_before.readable(), factory_, modules_);
    running.restore(before.readable());
    meshesAreOthers();  // the same, but in other states
    throw std::runtime_error(why);
  }
  meshesAreOthers();
}

void Session::meshesAreOthers() {
  ++mesh_changes_;
  if (mesh_changed_) mesh_changed_({});
}

std::vector<std::string> Session::restore(Checkpoint checkpoint, const std::string& path) {
  bool tells_convergence = false;
  try {
    UnconvergedSteps unconverged;
    for (const char* kept : {"constraint forces", "forces"}) checkpoint.values.take(kept);  // for Python (tools/python/engine.h)
    Archive run = checkpoint.values.take("run");
    tells_convergence = !run.entries().empty();
    if (run.entries().count("run:changed_meshes") > 0)
      throw std::runtime_error("meshes had changed in that run, and an earlier version wrote it, which did not keep them");
    if (tells_convergence) unconverged.serialize(run);
    run.checkAllRead();
    restoreMeshes(std::move(checkpoint.values));
    unconverged_ = unconverged;
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(fmt::format("{}: {}", path, error.what()));
  }
  std::vector<std::string> notes;
  if (!tells_convergence) notes.push_back(fmt::format("{} does not record which earlier steps converged", path));
  if (checkpoint.scene != scene_file_) notes.push_back(fmt::format("{} was written by {}", path, checkpoint.scene));
  if (checkpoint.build != buildIdentity())
    notes.push_back(fmt::format("{} was written by another build: the continued run may differ in its last bits", path));
  return notes;
}

}  // namespace stroma
