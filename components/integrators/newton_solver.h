// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "components/integrators/newton.h"
#include "framework/scene/component.h"

namespace stroma {

/// The role of a component that holds the settings of Newton's method for an integrator, and shows how it ended.
class NewtonSolver : public Component {
 public:
  std::string roleText() const override { return "Newton solver"; }
  /// Complete but for use_energy, which is the problem's.
  virtual NewtonSettings settings() const = 0;
  /// Called once, before any step, with the most values that noteResult() will bring.
  virtual void prepare(std::size_t values) = 0;
  virtual void noteResult(const StepReport& report, const Newton& newton) = 0;
};

/// The one that an integrator's link names, else the one of its node; null when there is none.
inline NewtonSolver* findNewtonSolver(const Component& integrator, const Link<NewtonSolver>& link) {
  return link.target() ? link.get() : integrator.find<NewtonSolver>();
}

}  // namespace stroma
