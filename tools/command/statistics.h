// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "framework/simulation/simulation.h"

namespace stroma::command {

/// Energies of all systems [J].
struct Energies {
  double kinetic = 0, elastic = 0, gravity = 0;
};
Energies energiesOf(const Simulation& simulation);

/// What a run cost and how well its solvers did.
class Statistics {
 public:
  explicit Statistics(long expected_steps);
  void add(const StepReport& report, double step_seconds);

  /// Sentences on solves that did not converge, summed over the run.
  std::vector<std::string> warnings() const;
  /// Wall time of a step [ms].
  double meanMs() const;
  double quantileMs(double q) const;
  nlohmann::ordered_json timing() const;
  nlohmann::ordered_json solvers() const;

 private:
  std::vector<double> step_ms_;
  std::map<SolveStop, long> stops_;
  long linear_iterations_ = 0, newton_iterations_ = 0, factorisations_ = 0;
  long linear_unconverged_ = 0, newton_unconverged_ = 0, constraints_unconverged_ = 0;
  std::string constraint_reason_;  ///< of the first step in which position constraints did not hold
  double residual_sum_ = 0, residual_worst_ = 0, newton_residual_worst_ = 0;
};

/// Seconds in each phase, summed over systems; `other` is what is left of the steps.
nlohmann::ordered_json phaseSeconds(const Simulation& simulation);
/// The largest amount of memory this process has held [bytes].
long peakMemory();

}  // namespace stroma::command
