// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "framework/algebra/linear_solver.h"

namespace stroma {

/// Implemented by linear solvers that choose their method from properties of the matrix.
class SolverChoice {
 public:
  virtual ~SolverChoice() = default;
  /// Chooses for this matrix, if not done yet. Creates the pattern of the matrix.
  virtual void choose(SystemMatrix& matrix) = 0;
  /// The last choice and its reason, a clause for the plan. Empty: none so far.
  virtual std::string choice() const = 0;
};

}  // namespace stroma
