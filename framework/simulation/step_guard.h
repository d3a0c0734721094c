// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "framework/simulation/step.h"

namespace stroma {

/// An observer that looks at the start of each step too and may refuse it: what the step would have to take into account and
/// cannot. It changes nothing.
class StepGuard {
 public:
  virtual ~StepGuard() = default;
  /// A sentence, or empty: the step may be made.
  virtual std::string refusal(const StepContext& context) = 0;
};

}  // namespace stroma
