// SPDX-License-Identifier: LGPL-2.1-or-later
// What a simulation stores, and how it goes on from there.
#include "framework/simulation/error_sentence.h"
#include "framework/simulation/simulation.h"

#include <fmt/format.h>

#include <stdexcept>
#include <tuple>

namespace stroma {

Archive Simulation::checkpoint() {
  complete();
  Archive archive;
  serializeEdits(archive);
  serialize(archive);
  return archive;
}

void Simulation::restore(Archive checkpoint) {
  end();
  const Archive before = this->checkpoint();
  const std::vector<RunEvent> events = events_;
  std::vector<std::pair<PhaseTimes, PhaseCounts>> spent;
  for (const auto& system : systems_) spent.emplace_back(system->times, system->counts);
  try {
    take(checkpoint.readable());
  } catch (...) {
    std::string not_put_back;
    try {
      take(before.readable());
    } catch (...) {
      not_put_back = errorSentence();
    }
    if (!not_put_back.empty())
      throw std::runtime_error(
          fmt::format("the checkpoint could neither be taken ({}) nor be given up ({}): load the scene again",
                      errorSentence(), not_put_back));
    events_ = events;
    for (std::size_t i = 0; i < systems_.size(); ++i) std::tie(systems_[i]->times, systems_[i]->counts) = spent[i];
    throw;
  }
}

void Simulation::take(Archive values) {
  forget();
  serializeEdits(values);
  serialize(values);
  values.checkAllRead();
}

void Simulation::serialize(Archive& archive) {
  archive.enter("simulation");
  archive.value("time", time_);
  archive.value("steps", steps_);
  archive.value("base_time", base_time_);
  archive.value("base_step", base_step_);
  archive.value("worked_on", worked_on_);
  for (State* state : states()) {
    archive.enter(state->path() + ":state");
    archive.rows("x", state->x().data, state->x().doubles());
    archive.rows("v", state->v().data, state->v().doubles());
  }
  serializeInputs(archive);  // before what integrators have concluded about the scene with them
  std::vector<Component*> components;
  root().collect(components);
  for (Component* component : components) {
    archive.enter(component->path());
    component->serialize(archive);
  }
  StepContext last = nextStep({});
  last.index = steps_, last.t = time_ - last.dt, last.t_end = time_;
  if (steps_ > base_step_) last.t = base_time_ + double(steps_ - 1 - base_step_) * last.dt;
  for (std::size_t i = 0; i < systems_.size(); ++i) {
    archive.enter(systems_[i]->integrator().path() + ":system");
    archive.value("turned", reversals_[i].turned);
    archive.value("in_a_row", reversals_[i].in_a_row);
    systems_[i]->serialize(archive, last);
  }
}

}  // namespace stroma
