// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/scene/component.h"
#include "framework/simulation/step.h"

namespace stroma {

class Simulation;

/// Reads after a step; changes nothing. What no observer asks for is not computed.
class Observer : public Component {
 public:
  std::string roleText() const override { return "observer"; }
  virtual void begin(const Simulation&) {}  ///< at t = 0, before the first step
  virtual void afterStep(const Simulation&, const StepContext&) = 0;
  virtual void end(const Simulation&) {}  ///< after the last step, also when the run diverged
  /// What it will do and how often, for `explain`: "writes out.vtu every 10 steps".
  virtual std::string describe() const = 0;
};

}  // namespace stroma
