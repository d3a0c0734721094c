// SPDX-License-Identifier: LGPL-2.1-or-later
// Where an assembled matrix lacks a part of the stiffness that products have, as of a fluid that couples all nodes of a body.
#pragma once
#include <optional>

#include "components/integrators/matrix_view.h"
#include "framework/simulation/system.h"

namespace stroma {

/// A matrix as a system has it, for solveWhole() to solve with all of it: conjugate gradients on products, with the scene's
/// solver, which may take the assembled matrix, as the preconditioner. The same equations are then solved whatever solver the
/// scene names.
class WholeMatrix final : public MatrixView {
 public:
  explicit WholeMatrix(SystemMatrix& base);
  /// As LinearSolver::solve(). A solver that has left a residual of the whole matrix as small as it says is believed.
  SolveReport solve(LinearSolver& solver, ConstRows b, Rows x, const SolveTerms& terms);

 private:
  SolveReport iterate(LinearSolver& solver, double norm_b, double goal, Rows x, StopToken stop);

  Vector residual_, preconditioned_, direction_, product_;  ///< shape (rows)
};

/// As LinearSolver::solve(), with all of the stiffness where the matrix is a WholeMatrix.
SolveReport solveWhole(LinearSolver& solver, SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms);

/// The same for each b[i] and x[i], as LinearSolver::solveAll().
SolveReport solveWhole(LinearSolver& solver, SystemMatrix& matrix, std::span<const ConstRows> b, std::span<const Rows> x,
                       const SolveTerms& terms);

/// Made at compile time: the matrix of a system, seen whole where some force field says that an assembled one is not.
class WholeIfNeeded {
 public:
  void compile(System& system);
  SystemMatrix& of(SystemMatrix& matrix) { return whole_ ? *whole_ : matrix; }

 private:
  std::optional<WholeMatrix> whole_;
};

}  // namespace stroma
