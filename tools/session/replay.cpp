// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/session/replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

#include "tools/session/action_file.h"

namespace stroma {
namespace {

class Replay final : public RunDirector {
 public:
  Replay(const Simulation& simulation, std::vector<RunEvent> events, std::string file)
      : events_(std::move(events)), file_(std::move(file)) {
    check(simulation);
    const auto is_past = [&simulation](const RunEvent& event) { return event.step < simulation.steps(); };
    done_ = std::size_t(std::find_if_not(events_.begin(), events_.end(), is_past) - events_.begin());
    if (std::any_of(events_.begin(), events_.end(),
                    [](const RunEvent& event) { return std::holds_alternative<AttributeEdit>(event.what); }))
      edits_before_ = simulation.edits();
  }

  void beforeStep(Simulation& simulation) override {
    for (; done_ < events_.size() && events_[done_].step <= simulation.steps(); ++done_) {
      try {
        simulation.make(events_[done_]);
      } catch (const ComponentError& error) {
        throw ReplayError(problem(done_, error).text());
      }
    }
  }
  void beforeReset(Simulation& simulation) override {
    if (!edits_before_) return;
    simulation.takeEditsBack();
    for (const Override& edit : *edits_before_) simulation.setAttribute(edit.path, edit.attribute, edit.value);
  }
  void restart() override { done_ = 0; }
  long firstFreeNumber() const override {
    long number = 1;
    for (const RunEvent& event : events_)
      if (const auto* change = std::get_if<InputChange>(&event.what)) number = std::max(number, change->number + 1);
    return number;
  }
  std::size_t done() const override { return done_; }
  void goOnFrom(std::size_t done) override { done_ = done; }

 private:
  void check(const Simulation& simulation) const {
    Diagnostics problems;
    std::size_t looked = 0;
    for (std::size_t i = 0; i < events_.size() && problems.errorCount() < told_action_problems; looked = ++i) {
      try {
        if (i > 0 && events_[i].step < events_[i - 1].step)
          throw ComponentError("it comes after one of a later step", "actions in the order of their steps");
        simulation.check(events_[i]);
      } catch (const ComponentError& error) {
        problems.add(problem(i, error));
      }
    }
    if (looked < events_.size()) problems.error({file_, 0, 0}, {}, "the actions after these were not looked at");
    if (problems.hasErrors()) throw SceneError(std::move(problems));
  }

  Problem problem(std::size_t index, const ComponentError& error) const {
    Problem problem;
    // the first line is the head of the file, then each event has one
    if (!file_.empty()) problem.where = {file_, int(index) + 2, 0};
    problem.message =
        fmt::format("action {} of the replay, before step {}: {}", index + 1, events_[index].step + 1, error.what());
    problem.expected = error.expected;
    problem.suggestion = error.suggestion;
    return problem;
  }

  std::vector<RunEvent> events_;
  std::string file_;
  std::size_t done_ = 0;
  std::optional<std::vector<Override>> edits_before_;  ///< those that stood before it, when it has edits
};

}  // namespace

void replay(Simulation& simulation, std::vector<RunEvent> events, const std::string& file) {
  simulation.setDirector(std::make_unique<Replay>(simulation, std::move(events), file));
}

std::size_t replayed(const Simulation& simulation) { return simulation.director() ? simulation.director()->done() : 0; }

}  // namespace stroma
