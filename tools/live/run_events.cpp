// SPDX-License-Identifier: LGPL-2.1-or-later
// What people do to a run: recorded, and done again.
#include "framework/simulation/run_events.h"

#include "framework/scene/diagnostics.h"
#include "framework/simulation/simulation.h"

namespace stroma {

void refuseAgain(const StateChange& change) {
  throw ComponentError("the positions of " + change.state + " were set by a program, and no record has the numbers",
                       "a run that only inputs and attributes have changed");
}

void RunLog::record(long step, AttributeEdit edit) { events_.push_back({step, std::move(edit)}); }
void RunLog::record(long step, StateChange change) { events_.push_back({step, std::move(change)}); }
void RunLog::clear() { events_.clear(); }
void RunLog::replaceBy(std::vector<RunEvent> events) { events_ = std::move(events); }

void RunLog::record(long step, InputChange change) {
  for (auto last = events_.rbegin(); last != events_.rend() && last->step == step; ++last) {
    auto* before = std::get_if<InputChange>(&last->what);
    if (!before) break;  // an edit may read what acts
    if (before->number != change.number) continue;
    if (!before->input || !change.input || !before->input->hasDerivativesOf(*change.input)) break;
    before->input = std::move(change.input);
    return;
  }
  events_.push_back({step, std::move(change)});
}

void Simulation::check(const RunEvent& event) const {
  if (const auto* edit = std::get_if<AttributeEdit>(&event.what)) {
    edits_.check(edit->path, edit->attribute);
  } else if (const auto* change = std::get_if<InputChange>(&event.what)) {
    if (change->input) inputs_.check(*change->input);
  } else {
    refuseAgain(std::get<StateChange>(event.what));
  }
}

void Simulation::make(const RunEvent& event) {
  if (const auto* edit = std::get_if<AttributeEdit>(&event.what)) {
    setAttribute(edit->path, edit->attribute, edit->text);
    return;
  }
  if (const auto* change = std::get_if<StateChange>(&event.what)) refuseAgain(*change);
  const auto& [number, input] = std::get<InputChange>(event.what);
  if (input) {
    inputs_.set(number, *input);
  } else if (inputs_.has(number)) {
    removeInput(number);
  }
}

void Simulation::setDirector(std::unique_ptr<RunDirector> director) {
  director_ = std::move(director);
  if (director_) inputs_.reserve(director_->firstFreeNumber());
}

}  // namespace stroma
