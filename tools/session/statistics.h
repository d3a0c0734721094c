// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <map>
#include <string>
#include <vector>

#include "framework/scene/archive.h"
#include "framework/simulation/energies.h"
#include "framework/simulation/simulation.h"

namespace stroma {

/// Requires all nodes to be up to date.
Energies energiesOf(const Simulation& simulation);

/// Counts the steps of a run that relied on solves that ended before their tolerance. A run that continues from a checkpoint
/// includes the steps before it.
struct UnconvergedSteps {
  long steps = 0;                                ///< of the run, successful or not
  long linear = 0, newton = 0, constraints = 0;  ///< steps
  long linear_at_limit = 0;                      ///< part of `linear`: a solve ended before its tolerance
  long linear_at_round_off = 0;                  ///< part of `linear_at_limit`: more iterations would not help
  long kept = 0;                                 ///< contacts violated within their tolerance
  long without_result = 0;                       ///< solves converged, but the state is not a valid result
  std::string without_result_reason;             ///< of the first of them
  std::string constraint_reason;                 ///< of the first step with violated constraints or contacts
  double worst_residual = 0, worst_newton_residual = 0;

  void add(const StepReport& report);
  /// Messages about them, summed over the run.
  std::vector<std::string> warnings() const;
  bool none() const { return linear + newton + constraints + kept + without_result == 0; }
  void serialize(Archive& archive);  ///< see Component::serialize()
};

/// Cost of the steps of a run, and the convergence of its solvers.
struct RunStatistics {
  std::vector<double> step_ms;  ///< wall time of each step [ms]
  std::map<SolveStop, long> stops;
  long linear_iterations = 0, newton_iterations = 0, factorisations = 0;
  long divided_steps = 0;  ///< of statics, see StepReport::load_parts
  int most_load_parts = 0;
  double residual_sum = 0;
  UnconvergedSteps unconverged;

  void add(const StepReport& report, double step_seconds);
  double meanMs() const;
  double quantileMs(double q) const;
};

}  // namespace stroma
