// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/simulation/step_progress.h"

namespace stroma {
namespace {

thread_local StepProgress* progress_of_thread = nullptr;

}  // namespace

StepProgress* stepProgress() { return progress_of_thread; }
void setStepProgress(StepProgress* progress) { progress_of_thread = progress; }

}  // namespace stroma
