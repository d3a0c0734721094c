// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>

namespace stroma {

/// Wall time spent in the parts of a step [s].
struct PhaseTimes {
  double force = 0, product = 0, assembly = 0, solve = 0, observers = 0, total = 0;
};

/// How often the parts of a step were executed.
struct PhaseCounts {
  long forces = 0, products = 0, assemblies = 0, gravity = 0;
};

/// Adds the wall time of its lifetime to a phase.
class PhaseTimer {
 public:
  explicit PhaseTimer(double& total) : total_(total) {}
  ~PhaseTimer() { total_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }
  PhaseTimer(const PhaseTimer&) = delete;
  PhaseTimer& operator=(const PhaseTimer&) = delete;

 private:
  double& total_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace stroma
