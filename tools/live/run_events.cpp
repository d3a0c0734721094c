// SPDX-License-Identifier: LGPL-2.1-or-later
// What people do to a run: recorded, and done again.
#include "framework/simulation/run_events.h"

#include "framework/scene/diagnostics.h"
#include "framework/simulation/simulation.h"

namespace stroma {

namespace {

/// In the place of a path, of a record that has been given up.
constexpr const char* given_up = "more than a record keeps";
/// A program that writes in each step makes no more of it: some 10,000 numbers, or a few lists of a large body.
constexpr std::size_t most_bytes = std::size_t(4) << 20;

std::size_t bytesOf(const RunEvent& event) {
  const auto* edit = std::get_if<AttributeEdit>(&event.what);
  return sizeof(RunEvent) + (edit ? edit->path.size() + edit->attribute.size() + edit->text.size() : 0);
}

/// Looks now and then, and with long texts oftener.
bool isTooMuch(const std::vector<RunEvent>& events) {
  if (events.size() % 256 != 0 && !(events.size() % 16 == 0 && bytesOf(events.back()) > 4096)) return false;
  std::size_t sum = 0;
  for (const RunEvent& event : events) sum += bytesOf(event);
  return sum > most_bytes;
}

/// What nobody can do again leaves nothing else to keep.
bool isGivenUp(const std::vector<RunEvent>& events) {
  return !events.empty() && std::holds_alternative<StateChange>(events.front().what);
}

}  // namespace

void refuseAgain(const StateChange& change) {
  if (change.state == given_up)
    throw ComponentError("a program has set attributes so often that no record has all of it", "a run that few changes are made to");
  throw ComponentError("the positions of " + change.state + " were set by a program, and no record has the numbers",
                       "a run that only inputs and attributes have changed");
}

void RunLog::record(long step, AttributeEdit edit) {
  if (isGivenUp(events_)) return;
  events_.push_back({step, std::move(edit)});
  if (isTooMuch(events_)) record(step, StateChange{given_up});
}
void RunLog::record(long step, StateChange change) {
  if (!isGivenUp(events_)) events_ = {{step, std::move(change)}};
}
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
