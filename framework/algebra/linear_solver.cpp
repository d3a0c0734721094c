// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/algebra/solve_watch.h"

namespace stroma {

std::string_view describe(SolveStop stop) {
  switch (stop) {
    case SolveStop::converged: return "converged";
    case SolveStop::iteration_limit: return "reached its iteration limit";
    case SolveStop::breakdown: return "broke down (the matrix is singular to round-off)";
    case SolveStop::not_definite: return "met a matrix that is not positive definite";
    case SolveStop::not_finite: return "met a number that is not finite";
    case SolveStop::zero_right_side: return "had nothing to solve (zero right side)";
    case SolveStop::stopped: return "was stopped";
    case SolveStop::stagnated: return "reached the accuracy that round-off allows before its tolerance";
  }
  return "ended for an unknown reason";
}

SolveWatch*& solveWatch() {
  static thread_local SolveWatch* watch = nullptr;
  return watch;
}

}  // namespace stroma
