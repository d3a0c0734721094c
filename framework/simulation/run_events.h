// SPDX-License-Identifier: LGPL-2.1-or-later
// Changes of a run from outside, and their record.
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

/// The arguments of Simulation::setAttribute().
struct AttributeEdit {
  std::string path, attribute, text;
};

/// A call of Simulation::setState(). Its numbers are not stored, so a record of events cannot repeat it.
struct StateChange {
  std::string state;  ///< its path
};
/// Throws ComponentError: such a change cannot be repeated.
[[noreturn]] void refuseAgain(const StateChange& change);

struct RunEvent {
  long step = 0;  ///< steps made before it
  std::variant<InputChange, AttributeEdit, StateChange> what;
};

/// All changes of a run from outside.
class RunLog {
 public:
  const std::vector<RunEvent>& events() const { return events_; }
  /// `step`: steps made so far. A target, force or ball position that is replaced before the next step has no effect and is
  /// not kept.
  void record(long step, InputChange change);
  void record(long step, AttributeEdit edit);
  void record(long step, StateChange change);
  void clear();
  void replaceBy(std::vector<RunEvent> events);

 private:
  std::vector<RunEvent> events_;
};

}  // namespace stroma
