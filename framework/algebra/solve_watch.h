// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/algebra/linear_solver.h"

namespace stroma {

class LagrangianRows;
class System;

/// Sees the equations of the steps that a thread makes, for whoever asks for those of the last one. It changes nothing.
struct SolveWatch {
  virtual ~SolveWatch() = default;
  virtual void solved(SystemMatrix& matrix, ConstRows b, ConstRows x) = 0;
  /// Where the directions of forces of constraint are taken: A u = J^T p moves positions by displacement u.
  virtual void conditions(const System& system, const LagrangianRows& rows, double displacement) = 0;
};
SolveWatch*& solveWatch();  ///< of this thread; null: nobody watches

}  // namespace stroma
