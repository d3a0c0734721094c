// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "framework/algebra/linear_solver.h"

namespace stroma {

/// Everything derived from the time step, computed once.
struct StepContext {
  long index = 0;    ///< number of the step, from 1
  double t = 0;      ///< time at the start [s]
  double dt = 0;     ///< [s]
  double t_end = 0;  ///< t + dt
  StopToken stop{};  ///< a step that is asked to stop is given up, and never half made
};

/// What a step did. Non-convergence is reported here, not in a log.
struct StepReport {
  bool diverged = false;  ///< the state is not usable: the run stops
  bool stopped = false;   ///< StepContext::stop was requested: the state is not usable either, but nothing is wrong
  bool unsolved = false;  ///< statics did not reach equilibrium, or a history reports a fault: no result
  std::string reason;     ///< a sentence, when diverged or not converged
  int newton_iterations = 0;
  int load_parts = 0;         ///< of statics: into how many parts the step was divided, those that failed included
  int linear_iterations = 0;  ///< summed over the Newton iterations
  int factorisations = 0;
  double solve_seconds = 0;    ///< wall time of the linear solves, their products and assembly included
  double linear_residual = 0;  ///< relative, of the last linear solve
  bool linear_converged = true;
  SolveStop linear_stop = SolveStop::converged;
  bool linear_at_limit = false;  ///< a solve ended at its iteration limit, or stagnated at round-off
  double newton_residual = 0;    ///< relative, where a Newton method ran
  bool newton_converged = true;
  int constraint_sweeps = 0;          ///< turns of the position constraints, for positions and for velocities
  bool constraints_converged = true;  ///< false: positions or velocities break a position constraint, no result
  std::string constraint_reason;      ///< a sentence, when not constraints_converged
  /// The step is not taken: x and v are put back.
  bool failed() const { return diverged || stopped; }
};

}  // namespace stroma
