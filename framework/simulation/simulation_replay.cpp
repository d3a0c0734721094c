// SPDX-License-Identifier: LGPL-2.1-or-later
// What was done to a run from outside, done again.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "framework/scene/live_edit.h"
#include "framework/simulation/simulation.h"

namespace stroma {

long Simulation::firstNumber() const {
  long number = 1;
  for (const RunEvent& event : replay_)
    if (const auto* change = std::get_if<InputChange>(&event.what)) number = std::max(number, change->number + 1);
  return number;
}

void Simulation::checkReplay(const RunEvent& event) const {
  if (const auto* edit = std::get_if<AttributeEdit>(&event.what)) {
    checkEdit(LiveEdit(root(), edit->path, edit->attribute));
  } else if (const auto& input = std::get<InputChange>(event.what).input) {
    State* state = nullptr;
    System& system = systemOf(*input, state);
    checkInput(*input, *state);
    if (const StateOwner* owner = system.integrator().stateOwner()) owner->checkInputOn(*state, *input);
  }
}

Problem Simulation::replayProblem(std::size_t index, const ComponentError& error) const {
  Problem problem;
  // the first line is the head of the file, then each event has one
  if (!replay_file_.empty()) problem.where = {replay_file_, int(index) + 2, 0};
  problem.message =
      fmt::format("action {} of the replay, before step {}: {}", index + 1, replay_[index].step + 1, error.what());
  problem.expected = error.expected;
  problem.suggestion = error.suggestion;
  return problem;
}

void Simulation::replay(std::vector<RunEvent> events, const std::string& file) {
  std::swap(replay_, events);
  std::string file_before = std::exchange(replay_file_, file);
  Diagnostics problems;
  std::size_t looked = 0;
  for (std::size_t i = 0; i < replay_.size() && problems.errorCount() < told_action_problems; looked = ++i) {
    try {
      if (i > 0 && replay_[i].step < replay_[i - 1].step)
        throw ComponentError("it comes after one of a later step", "actions in the order of their steps");
      checkReplay(replay_[i]);
    } catch (const ComponentError& error) {
      problems.add(replayProblem(i, error));
    }
  }
  if (looked < replay_.size()) problems.error({replay_file_, 0, 0}, {}, "the actions after these were not looked at");
  if (problems.hasErrors()) {
    replay_ = std::move(events), replay_file_ = std::move(file_before);
    throw SceneError(std::move(problems));
  }
  const auto is_past = [this](const RunEvent& event) { return event.step < steps_; };
  next_replayed_ = std::size_t(std::find_if_not(replay_.begin(), replay_.end(), is_past) - replay_.begin());
  next_input_ = std::max(next_input_, firstNumber());
  edits_before_replay_.reset();
  if (std::any_of(replay_.begin(), replay_.end(),
                  [](const RunEvent& event) { return std::holds_alternative<AttributeEdit>(event.what); }))
    edits_before_replay_ = edits_;
}

void Simulation::takeReplayedEditsBack() {
  if (!edits_before_replay_) return;
  const std::vector<Edit> before = *edits_before_replay_;
  takeEditsBack();
  for (const Edit& edit : before) setAttribute(edit.path, edit.attribute, edit.text);
}

void Simulation::replayDue() {
  for (; next_replayed_ < replay_.size() && replay_[next_replayed_].step <= steps_; ++next_replayed_) {
    try {
      replayOne(replay_[next_replayed_]);
    } catch (const ComponentError& error) {
      throw ReplayError(replayProblem(next_replayed_, error).text());
    }
  }
}

void Simulation::replayOne(const RunEvent& event) {
  if (const auto* edit = std::get_if<AttributeEdit>(&event.what)) {
    setAttribute(edit->path, edit->attribute, edit->text);
    return;
  }
  const auto& [number, input] = std::get<InputChange>(event.what);
  if (input) {
    setInput(number, *input);
  } else if (inputs_.count(number) > 0) {  // it may have ended before the checkpoint of the same step
    removeInput(number);
  }
}

}  // namespace stroma
