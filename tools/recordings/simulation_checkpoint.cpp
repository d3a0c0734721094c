// SPDX-License-Identifier: LGPL-2.1-or-later
// What a simulation stores, and how it goes on from there.
#include "framework/simulation/simulation.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>
#include <tuple>

#include "tools/platform/error_sentence.h"

namespace stroma {

Archive Simulation::checkpoint() {
  complete();
  Archive archive;
  edits_.serialize(archive);
  serialize(archive);
  return archive;
}

void Simulation::restore(Archive checkpoint) {
  end();
  const Archive before = this->checkpoint();
  const std::vector<RunEvent> events = log_.events();
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
    log_.replaceBy(events);
    for (std::size_t i = 0; i < systems_.size(); ++i) std::tie(systems_[i]->times, systems_[i]->counts) = spent[i];
    throw;
  }
}

void Simulation::take(Archive values) {
  forget();
  edits_.serialize(values);
  serialize(values);
  values.checkAllRead();
}

void Simulation::serialize(Archive& archive) {
  archive.enter("simulation");
  clock_.serialize(archive);
  if (archive.isReading()) {  // steps of another length than those of the checkpoint are counted from here
    const double way = clock_.next(dt()).t_end - clock_.time(), round_off = 1e-12 * std::abs(clock_.time());
    if (std::abs(way - dt()) > 1e-6 * dt() + round_off) clock_.countFromHere();
  }
  watch_.serialize(archive);
  for (State* state : states()) {
    archive.enter(state->path() + ":state");
    archive.rows("x", state->x().data, state->x().doubles());
    archive.rows("v", state->v().data, state->v().doubles());
  }
  archive.enter("inputs");  // before what integrators have concluded about the scene with them
  inputs_.serialize(archive);
  std::size_t replayed = director_ ? director_->done() : 0;
  archive.value("replayed", replayed);
  if (archive.isReading() && director_) director_->goOnFrom(replayed);
  std::vector<Component*> components;
  root().collect(components);
  for (Component* component : components) {
    archive.enter(component->path());
    component->serialize(archive);
  }
  const StepContext last = clock_.last(dt());
  for (std::size_t i = 0; i < systems_.size(); ++i) {
    archive.enter(systems_[i]->integrator().path() + ":system");
    watch_.serialize(i, archive);
    systems_[i]->serialize(archive, last);
  }
}

}  // namespace stroma
