// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <map>

#include "framework/scene/archive.h"
#include "framework/scene/node.h"
#include "framework/simulation/input.h"
#include "framework/simulation/run_clock.h"
#include "framework/simulation/run_events.h"
#include "framework/simulation/run_watch.h"

namespace stroma {

/// The external forces that act on a run, by number. All changes are recorded.
class RunInputs {
 public:
  RunInputs(const std::unique_ptr<Node>& root, const Systems& systems, const RunClock& clock, RunLog& log, RunWatch& watch);
  RunInputs(const RunInputs&) = delete;

  /// Throws ComponentError if this input cannot act.
  void check(const Input& input) const;
  long add(const Input& input);
  void change(long number, const Input& input);
  void remove(long number);
  /// Begins or changes the input with this number.
  void set(long number, const Input& input);
  bool has(long number) const { return inputs_.count(number) > 0; }

  /// Removes all inputs and sets the next number. Nothing is recorded.
  void drop(long next_number);
  /// add() returns no number below this one.
  void reserve(long next_number) { next_ = std::max(next_, next_number); }
  void serialize(Archive& archive);  ///< see Component::serialize()

 private:
  System& systemOf(const Input& input, State*& state) const;

  const std::unique_ptr<Node>& root_;  ///< the tree may be replaced
  const Systems& systems_;
  const RunClock& clock_;
  RunLog& log_;
  RunWatch& watch_;
  std::map<long, Input> inputs_;  ///< active inputs
  long next_ = 1;
};

}  // namespace stroma
