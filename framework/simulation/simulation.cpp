// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/simulation/simulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <stdexcept>

#include "framework/mechanics/lagrangian_constraint.h"
#include "framework/mechanics/step_limiter.h"
#include "framework/scene/spans.h"
#include "framework/simulation/expectation.h"
#include "framework/simulation/system_report.h"
#include "framework/simulation/step_guard.h"
#include "framework/simulation/step_limits.h"

namespace stroma {
namespace {

/// Tells constraints where a run starts, as a step that takes no time. False: one of them refuses it.
bool startIsGood(const System& system, Diagnostics& diagnostics) {
  bool is_good = true;
  for (LagrangianConstraint* constraint : system.actors().lagrangian_constraints) {
    auto* listener = dynamic_cast<StepListener*>(constraint);
    try {
      if (listener) listener->stepBegins(system.mappingChain().positions(system.x), 0, 0);
    } catch (const ComponentError& error) {
      const auto& component = dynamic_cast<const Component&>(*constraint);
      diagnostics.error(component.where(), component.path(), error.what(), error.expected, error.suggestion);
      is_good = false;
    }
  }
  return is_good;
}

/// Null when the integrator, or what it found below itself, cannot work as written: the reason is in `diagnostics`.
std::unique_ptr<System> compileSystem(const SystemMembers& members, Diagnostics& diagnostics) {
  Integrator& integrator = *members.integrator;
  const Span span("compile", &integrator);
  try {
    auto system = std::make_unique<System>(members);
    integrator.compile(*system);
    placeStart(*system), checkStepLimits(*system);
    if (startIsGood(*system, diagnostics)) return system;
  } catch (const ComponentError& error) {
    diagnostics.error(integrator.where(), integrator.path(), error.what(), error.expected, error.suggestion);
  } catch (const DependencyFailed&) {
    // the component that failed has been reported already
  }
  return nullptr;
}

/// FNV-1a, 64 bits, over the bytes of the bits of a number, lowest byte first.
void hashNumber(std::uint64_t& hash, double number) {
  const auto bits = std::bit_cast<std::uint64_t>(number);
  for (int shift = 0; shift < 64; shift += 8) hash = (hash ^ (bits >> shift & 0xff)) * 1099511628211ull;
}

void hashRows(std::uint64_t& hash, ConstRows rows) {
  for (Index i = 0; i < rows.count; ++i)
    for (int c = 0; c < 3; ++c) hashNumber(hash, rows[i][c]);
}

/// Adds what one system did to the report of the whole step: counts are summed, of the rest the worst is kept.
void merge(StepReport&& part, StepReport& whole) {
  whole.newton_iterations += part.newton_iterations;
  whole.load_parts = std::max(whole.load_parts, part.load_parts);
  whole.linear_iterations += part.linear_iterations;
  whole.factorisations += part.factorisations;
  whole.solve_seconds += part.solve_seconds;
  whole.linear_residual = std::max(whole.linear_residual, part.linear_residual);
  whole.newton_residual = std::max(whole.newton_residual, part.newton_residual);
  whole.newton_converged = whole.newton_converged && part.newton_converged;
  whole.unsolved = whole.unsolved || part.unsolved;
  whole.constraint_sweeps += part.constraint_sweeps;
  whole.constraints_converged = whole.constraints_converged && part.constraints_converged;
  if (whole.linear_converged) whole.linear_stop = part.linear_stop;
  whole.linear_converged = whole.linear_converged && part.linear_converged;
  whole.linear_at_limit = whole.linear_at_limit || part.linear_at_limit;
  if (whole.constraint_reason.empty()) whole.constraint_reason = std::move(part.constraint_reason);
  if (whole.reason.empty()) whole.reason = std::move(part.reason);
}

}  // namespace

Simulation::Simulation(Scene scene)
    : scene_(std::move(scene)),
      inputs_(scene_.root, systems_, clock_, log_, watch_),
      edits_(scene_.root, systems_, snapshots_, clock_, log_, watch_) {
  Diagnostics& diagnostics = scene_.diagnostics;
  const std::vector<SystemMembers> found = findSystems(root(), diagnostics);
  for (const SystemMembers& members : found)
    if (auto system = compileSystem(members, diagnostics)) systems_.push_back(std::move(system));
  if (!(root().root_time + dt() > root().root_time))
    diagnostics.error(root().where(), root().path() + ".time",
                      fmt::format("at {:g} s a step of {:g} s is lost in round-off of the time", root().root_time, dt()),
                      "a start nearer to zero, or a longer dt");
  observers_.collect(root());
  if (!diagnostics.hasErrors()) observers_.compile(diagnostics);
  if (diagnostics.hasErrors()) throw SceneError(diagnostics);

  if (found.empty()) diagnostics.warning(root().where(), root().path(), "the scene has no integrator: nothing moves");
  for (const auto& system : systems_) fault_watches_.emplace_back(*system);
  snapshots_.compile(systems_);
  watch_.compile(systems_);
  root().collect(histories_);
  observers_.watchFollowers();
  clock_.start(root().root_time);
}

Simulation::~Simulation() = default;

std::vector<State*> Simulation::states() const {
  std::vector<State*> states;
  root().collect(states);
  std::erase_if(states, [](const State* state) { return !state->isBound(); });
  return states;
}

StepReport Simulation::step(StopToken stop) {
  if (stepping_) throw std::logic_error("a step was started within another step");
  begin();
  if (director_) director_->beforeStep(*this);
  struct Ended {
    bool& stepping;
    ~Ended() { stepping = false; }
  } const ended{stepping_};
  stepping_ = true;
  return makeStep(stop);
}

StepReport Simulation::makeStep(StopToken stop) {
  StepContext context = clock_.next(dt());
  context.stop = stop;
  StepReport report;
  for (Observer* observer : observers_.all())
    if (auto* guard = dynamic_cast<StepGuard*>(observer)) {
      complete();
      if (std::string why = guard->refusal(context); !why.empty()) {
        report.diverged = true;
        report.reason = fmt::format("step {} (from t = {:.6g} s), {}: {}", context.index, context.t, observer->path(), why);
        return report;
      }
    }
  for (std::size_t i = 0; i < systems_.size() && !report.failed(); ++i) {
    try {
      advance(i, context, report);
    } catch (...) {  // of what others have written, a force in another language
      if (!isLean(i)) takeBack(i);
      throw;
    }
  }
  if (report.failed()) return report;
  for (const auto& system : systems_) {
    const PhaseTimer timer(system->times.total);
    system->integrator().stepTaken(context);
  }
  for (History* history : histories_) endHistory(*history, context, report);
  clock_.stepMade(context);
  for (Observer* observer : observers_.all())
    if (auto* expectation = dynamic_cast<Expectation*>(observer)) expectation->stepMade(report);
  observers_.afterStep(context);
  return report;
}

void Simulation::advance(std::size_t index, const StepContext& context, StepReport& report) {
  System& system = *systems_[index];
  const PhaseTimer timer(system.times.total);
  const Span span("step", &system.integrator());
  // where several systems move, one may have to go back because another one failed
  const bool owns_state = system.integrator().stateOwner(), lean = isLean(index);
  Snapshot& before = snapshots_.good(index);
  if (!lean) before.take(system);
  system.keepSolver();

  if (!owns_state) system.beginStep(context);
  StepReport part = heard("integrate", &system.integrator())->step(system, context);
  if (part.stopped) {
    if (!lean) takeBack(index);
    report.stopped = true;
    return;
  }
  if (!part.diverged) system.endStep(context, before.x, part);
  std::string fault = part.diverged ? part.reason : lean ? std::string() : fault_watches_[index].firstFault(before.x);
  if (part.diverged && fault.empty()) fault = "the integrator abandoned the step";

  system.times.solve += part.solve_seconds;
  if (fault.empty()) {
    if (std::string overlap = overlapIn(system); !overlap.empty()) {
      part.constraints_converged = false;
      part.constraint_reason = whereAndWhy(system, context, overlap, "");
    }
    if (part.unsolved) part.reason = whereAndWhy(system, context, part.reason, "");
    if (!lean && system.integrator().keepsEnergy()) watch_.look(index, system, before, context);
    if (!owns_state) system.computeRequestedForce(context.t_end);
  } else {
    if (!lean) takeBack(index);
    report.diverged = true;
    // the states are those of the last good step: the worst elements are where the trouble began, not where it ended
    report.reason = whereAndWhy(system, context, fault, " before the step");
  }
  merge(std::move(part), report);
}

void Simulation::endHistory(History& history, const StepContext& context, StepReport& report) const {
  history.stepEnded(context.t_end);
  const std::string fault = history.fault();
  if (fault.empty()) return;
  // a step in time may swing and settle; an equilibrium may not
  const auto* field = dynamic_cast<const ForceField*>(&history);
  const bool without_time = std::any_of(systems_.begin(), systems_.end(), [field](const auto& system) {
    const auto& fields = system->forceFields();
    return !system->integrator().movesInTime() && std::find(fields.begin(), fields.end(), field) != fields.end();
  });
  if (!without_time) return;
  const std::string before = report.unsolved || report.reason.empty() ? report.reason : "; " + report.reason;
  if (!report.unsolved) report.reason = fmt::format("step {} (to t = {:.6g} s): {}{}", context.index, context.t_end, fault, before);
  report.unsolved = true;
}

/// Systems up to the one that failed, as they were before the step.
void Simulation::takeBack(std::size_t failed) {
  snapshots_.putGoodBack(systems_, failed + 1);
  for (std::size_t i = 0; i <= failed; ++i) systems_[i]->takeSolverBack();
}

void Simulation::reset() {
  end();
  if (director_) director_->beforeReset(*this);
  if (first_) becomeFirst();
  forget();
  for (const Override& edit : edits()) log_.record(0, AttributeEdit{edit.path, edit.attribute, edit.value});
}

void Simulation::forget() {
  if (director_) director_->restart();
  inputs_.drop(director_ ? director_->firstFreeNumber() : 1);
  log_.clear();
  snapshots_.putStartBack(systems_);
  for (const auto& system : systems_) {
    clear(system->f);
    system->times = {};
    system->counts = {};
  }
  std::vector<Component*> components;
  root().collect(components);
  for (Component* component : components) component->reset();
  watch_.reset();
  clock_.start(root().root_time);
}

std::uint64_t Simulation::stateHash() const {
  complete();
  std::uint64_t hash = 14695981039346656037ull;
  for (const State* state : states()) {
    hashRows(hash, state->x());
    hashRows(hash, state->v());
    for (Index i = 0; i < state->size(); ++i)
      if (state->kindOf(i) == RowKind::turn) hashNumber(hash, state->x().data[i * row_doubles + 3]);
  }
  return hash;
}

}  // namespace stroma
