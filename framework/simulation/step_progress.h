// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <atomic>

namespace stroma {

/// Progress of the current step. The stepping thread writes it; another thread reads and displays it.
struct StepProgress {
  std::atomic<int> newton_iterations = 0;   ///< of the current solve
  std::atomic<double> newton_residual = 0;  ///< relative, of the current iterate
  std::atomic<double> newton_goal = 0;      ///< relative residual at which the solve ends
};

/// Sets where the steps of the calling thread report their progress. Null, the default in every thread: nowhere.
/// `progress` must outlive the steps, or be replaced by null before it is destroyed.
void setStepProgress(StepProgress* progress);

/// Reports the progress of Newton's method.
void tellNewtonIterate(int iterations, double relative_residual, double goal);

}  // namespace stroma
