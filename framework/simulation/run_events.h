// SPDX-License-Identifier: LGPL-2.1-or-later
// Changes made to a run from outside, and the record of them.
#pragma once
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "framework/simulation/input.h"

namespace stroma {

/// An input that began, changed, or (without `input`) ended.
struct InputChange {
  long number = 0;  ///< of Simulation::addInput()
  std::optional<Input> input{};
};

/// What Simulation::setAttribute() was given.
struct AttributeEdit {
  std::string path, attribute, text;
};

/// Simulation::setState() was called. The numbers are not kept, so that no record of events repeats it.
struct StateChange {
  std::string state;  ///< its path
};
/// Throws ComponentError: such a change cannot be done again.
[[noreturn]] void refuseAgain(const StateChange& change);

struct RunEvent {
  long step = 0;  ///< how many had been made
  std::variant<InputChange, AttributeEdit, StateChange> what;
};

/// All changes made to a run from outside.
class RunLog {
 public:
  const std::vector<RunEvent>& events() const { return events_; }
  /// `step`: how many have been made. A target, force or place of a ball that another one follows before the same step
  /// has had no effect.
  void record(long step, InputChange change);
  void record(long step, AttributeEdit edit);
  void record(long step, StateChange change);
  void clear();
  void replaceBy(std::vector<RunEvent> events);

 private:
  std::vector<RunEvent> events_;
};

}  // namespace stroma
