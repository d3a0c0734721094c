// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/algebra/linear_solver.h"

#include <algorithm>

namespace stroma {

std::string_view describe(SolveStop stop) {
  switch (stop) {
    case SolveStop::converged: return "converged";
    case SolveStop::iteration_limit: return "reached its iteration limit";
    case SolveStop::breakdown: return "broke down (the matrix is singular to round-off)";
    case SolveStop::not_definite: return "met a matrix that is not positive definite";
    case SolveStop::not_finite: return "met a non-finite number";
    case SolveStop::zero_right_side: return "had nothing to solve (zero right side)";
    case SolveStop::stopped: return "was stopped";
    case SolveStop::stagnated: return "stagnated at round-off before reaching its tolerance";
  }
  return "ended for an unknown reason";
}

bool SolveReport::add(const SolveReport& one) {
  iterations += one.iterations, factored = factored || one.factored;
  relative_residual = std::max(relative_residual, one.relative_residual);
  const bool is_over = !one.usable() || one.stop == SolveStop::breakdown, is_zero = one.stop == SolveStop::zero_right_side;
  if (is_over || stop == SolveStop::zero_right_side || (stop == SolveStop::converged && !is_zero)) stop = one.stop, row = one.row;
  return !is_over;
}

SolveReport LinearSolver::solveAll(SystemMatrix& matrix, std::span<const ConstRows> b, std::span<const Rows> x, const SolveTerms& terms) {
  SolveReport all{.stop = SolveStop::zero_right_side};
  for (std::size_t i = 0; i < b.size(); ++i)
    if (!all.add(solve(matrix, b[i], x[i], terms))) break;
  return all;
}

}  // namespace stroma
