// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "framework/algebra/linear_solver.h"

namespace stroma {

/// Times of a step, computed once.
struct StepContext {
  long index = 0;    ///< step number, from 1
  double t = 0;      ///< time at the start [s]
  double dt = 0;     ///< [s]
  double t_end = 0;  ///< t + dt
  StopToken stop{};  ///< a stopped step is abandoned as a whole
};

/// The outcome of a step. Failure to converge is reported here, not in a log.
struct StepReport {
  bool diverged = false;  ///< the state is not usable: the run stops
  bool stopped = false;   ///< StepContext::stop was set before the end of the step: the state is unusable too, without an error
  bool unsolved = false;  ///< no result: statics are not in equilibrium, or a history reports a fault
  std::string reason;     ///< a sentence if it diverged or did not converge
  int newton_iterations = 0;
  int load_parts = 0;         ///< of statics: the number of parts of the step, including failed ones
  int linear_iterations = 0;  ///< summed over the Newton iterations
  int factorisations = 0;
  double solve_seconds = 0;    ///< wall time of linear solves, including products and assembly
  double linear_residual = 0;  ///< relative, of the last linear solve
  bool linear_converged = true;
  SolveStop linear_stop = SolveStop::converged;
  bool linear_at_limit = false;  ///< a solve reached its iteration limit or stagnated at round-off
  double newton_residual = 0;    ///< relative, if Newton's method was used
  bool newton_converged = true;
  int constraint_sweeps = 0;          ///< sweeps of the position constraints, for positions and velocities
  bool constraints_converged = true;  ///< false: positions or velocities violate a position constraint, no result
  std::string constraint_reason;      ///< a sentence if not constraints_converged
  /// The step is rejected: x and v are restored.
  bool failed() const { return diverged || stopped; }
};

}  // namespace stroma
