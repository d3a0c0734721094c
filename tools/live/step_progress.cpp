// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/simulation/step_progress.h"

namespace stroma {
namespace {

thread_local StepProgress* progress_of_thread = nullptr;

}  // namespace

void setStepProgress(StepProgress* progress) { progress_of_thread = progress; }

void tellNewtonIterate(int iterations, double relative_residual, double goal) {
  StepProgress* const progress = progress_of_thread;
  if (!progress) return;
  progress->newton_goal.store(goal, std::memory_order_relaxed);
  progress->newton_residual.store(relative_residual, std::memory_order_relaxed);
  progress->newton_iterations.store(iterations, std::memory_order_relaxed);
}

}  // namespace stroma
