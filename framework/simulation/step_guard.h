// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "framework/simulation/step.h"

namespace stroma {

/// An observer that is also called before each step and may reject it because of something the step cannot account for.
/// It changes nothing.
class StepGuard {
 public:
  virtual ~StepGuard() = default;
  /// A reason to reject the step, or empty.
  virtual std::string refusal(const StepContext& context) = 0;
};

}  // namespace stroma
