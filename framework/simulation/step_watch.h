// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/simulation/system.h"

namespace stroma {

class LagrangianRows;

/// Sees the equations of the steps that a thread makes, for callers that ask for the last ones. It changes nothing.
struct StepWatch {
  virtual ~StepWatch() = default;
  virtual void solved(SystemMatrix& matrix, ConstRows b, ConstRows x) = 0;
  /// Where the directions of forces of constraint are taken: A u = J^T p moves positions by displacement u.
  virtual void constraintGradients(const System& system, const LagrangianRows& rows, double displacement) = 0;
};
StepWatch*& stepWatch();  ///< of this thread; null: nobody watches

}  // namespace stroma
