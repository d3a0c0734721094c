// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/scene/component.h"
#include "framework/simulation/step.h"

namespace stroma {

class System;

/// Moves a System through a step. A node's integrator owns every state of its node and below.
class Integrator : public Component {
 public:
  std::string roleText() const override { return "integrator"; }
  /// Called once: allocate every vector the steps need; check that the system has what the method needs.
  virtual void compile(System& system) = 0;
  virtual StepReport step(System& system, const StepContext& context) = 0;
  /// False for statics: a step then has no velocities that a position constraint could correct.
  virtual bool movesInTime() const { return true; }
  /// One line for `explain`: what a step does.
  virtual std::string describe() const = 0;
};

}  // namespace stroma
