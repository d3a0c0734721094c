// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>

#include "framework/simulation/simulation.h"

namespace stroma::command {

/// How far a run is, on standard error: on a terminal one line that is redrawn, in a pipe at most ten lines.
class Progress {
 public:
  /// `quiet`: nothing at all.
  Progress(long steps, bool quiet);
  void show(const Simulation& simulation, const StepReport& report);
  /// Leaves the terminal's line.
  void finish();

 private:
  void print(const Simulation& simulation, const StepReport& report, const char* before, const char* after);

  using Clock = std::chrono::steady_clock;
  long steps_;
  bool quiet_, terminal_;
  bool line_open_ = false;
  long next_line_;  ///< in a pipe: the step of the next line
  Clock::time_point start_ = Clock::now(), last_drawn_{};
};

}  // namespace stroma::command
