// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/simulation/system.h"

namespace stroma {

class LagrangianRows;

/// Receives the equations of the steps of a thread, for callers that want those of the last step. It changes nothing.
struct StepWatch {
  virtual ~StepWatch() = default;
  virtual void solved(SystemMatrix& matrix, ConstRows b, ConstRows x) = 0;
  /// Called when the directions of constraint forces are set: A u = J^T p moves positions by displacement u.
  virtual void constraintGradients(const System& system, const LagrangianRows& rows, double displacement) = 0;
};
StepWatch*& stepWatch();  ///< of this thread; null: none

}  // namespace stroma
