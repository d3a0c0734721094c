// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <map>
#include <string>
#include <vector>

#include "framework/simulation/simulation.h"

namespace stroma {

/// Energies of all systems [J].
struct Energies {
  double kinetic = 0, elastic = 0, gravity = 0;
};
Energies energiesOf(const Simulation& simulation);

/// What the steps of a run cost and how well its solvers did.
struct RunStatistics {
  std::vector<double> step_ms;  ///< wall time of each step [ms]
  std::map<SolveStop, long> stops;
  long linear_iterations = 0, newton_iterations = 0, factorisations = 0;
  long linear_unconverged = 0, newton_unconverged = 0, constraints_unconverged = 0;  ///< steps
  long divided_steps = 0;  ///< of statics, see StepReport::load_parts
  int most_load_parts = 0;
  long without_result = 0;            ///< steps whose solves converged, to what is no result
  std::string without_result_reason;  ///< of the first of them
  std::string constraint_reason;      ///< of the first step in which position constraints did not hold
  double residual_sum = 0, residual_worst = 0, newton_residual_worst = 0;

  void add(const StepReport& report, double step_seconds);
  /// Sentences on solves that did not converge, summed over the run.
  std::vector<std::string> warnings() const;
  /// False when a step relied on a solve that ended before its tolerance.
  bool allConverged() const {
    return linear_unconverged + newton_unconverged + constraints_unconverged + without_result == 0;
  }
  double meanMs() const;
  double quantileMs(double q) const;
};

}  // namespace stroma
