// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>

namespace stroma {

class Simulation;

/// Changes a run from inside, before its steps: a replay.
class RunDirector {
 public:
  virtual ~RunDirector() = default;
  /// Called before each step; the step is not made when it throws.
  virtual void beforeStep(Simulation& simulation) = 0;
  /// reset() follows: edits that it has made are not to stay.
  virtual void beforeReset(Simulation& simulation) = 0;
  /// The run is at its start again.
  virtual void restart() = 0;
  /// Inputs with lower numbers are its own.
  virtual long firstFreeNumber() const = 0;
  /// How many of its actions are done: stored in checkpoints.
  virtual std::size_t done() const = 0;
  virtual void goOnFrom(std::size_t done) = 0;
};

}  // namespace stroma
