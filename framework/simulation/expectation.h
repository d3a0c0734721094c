// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "framework/simulation/step.h"

namespace stroma {

/// An observer that compares results with expected values in the scene.
class Expectation {
 public:
  virtual ~Expectation() = default;
  virtual void stepMade(const StepReport&) {}  ///< before its afterStep()
  virtual long comparisons() const = 0;  ///< so far
  /// A sentence with the numbers of the first failed comparison; empty if none failed.
  virtual std::string failure() const = 0;
};

}  // namespace stroma
