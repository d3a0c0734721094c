// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "framework/simulation/step.h"

namespace stroma {

/// An observer that also looks at the start of each step and may reject it, if the step would have to account for something that
/// it cannot. It changes nothing.
class StepGuard {
 public:
  virtual ~StepGuard() = default;
  /// Why the step is rejected; empty if it may be made.
  virtual std::string refusal(const StepContext& context) = 0;
};

}  // namespace stroma
