// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <atomic>

namespace stroma {

/// The progress of the current step. The stepping thread writes it, another one reads and shows it.
struct StepProgress {
  std::atomic<int> newton_iterations = 0;   ///< made by the solve under way
  std::atomic<double> newton_residual = 0;  ///< relative, that of the present iterate
  std::atomic<double> newton_goal = 0;      ///< at which the solve ends, likewise relative
};

/// Where the steps of the calling thread write their progress. Null, the default of each thread: nowhere.
/// `progress` outlives the steps, or is replaced by null before it goes.
void setStepProgress(StepProgress* progress);

/// Writes the progress of a Newton solve.
void tellNewtonIterate(int iterations, double relative_residual, double goal);

}  // namespace stroma
