// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <atomic>

namespace stroma {

/// How far the step under way is. The thread that steps writes it, another one reads it and tells people.
struct StepProgress {
  std::atomic<int> newton_iterations = 0;   ///< made by the solve under way
  std::atomic<double> newton_residual = 0;  ///< relative, that of the present iterate
  std::atomic<double> newton_goal = 0;      ///< at which the solve ends, likewise relative
};

/// Where the steps of the calling thread tell how far they are. Null, as every thread begins: nobody wants to know.
/// `progress` outlives the steps, or is replaced by null before it goes.
void setStepProgress(StepProgress* progress);

/// Of a solve by Newton's method: who wants to know learns it.
void tellNewtonIterate(int iterations, double relative_residual, double goal);

}  // namespace stroma
