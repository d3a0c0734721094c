// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>

namespace stroma {

class Simulation;

/// Applies events to a run before its steps, such as a replay.
class RunDirector {
 public:
  virtual ~RunDirector() = default;
  /// Called before each step; the step is not made if it throws.
  virtual void beforeStep(Simulation& simulation) = 0;
  /// Called before reset(): undoes its edits.
  virtual void beforeReset(Simulation& simulation) = 0;
  /// The run is at its start again.
  virtual void restart() = 0;
  /// Inputs with lower numbers belong to it.
  virtual long firstFreeNumber() const = 0;
  /// The number of events applied so far, stored in checkpoints.
  virtual std::size_t done() const = 0;
  virtual void goOnFrom(std::size_t done) = 0;
};

}  // namespace stroma
