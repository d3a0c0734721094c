// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "framework/mechanics/state.h"
#include "framework/scene/component.h"
#include "framework/simulation/step.h"

namespace stroma {

class Simulation;

/// Reads results after a step and changes nothing. Quantities that no observer asks for are not computed.
class Observer : public Component {
 public:
  std::string roleText() const override { return "observer"; }
  /// Called at load, when everything that moves is compiled. Throws ComponentError for whatever begin() or afterStep() could
  /// not do. Writes nothing.
  virtual void compile(const Simulation&) {}
  virtual void begin(const Simulation&) {}  ///< at t = 0, before the first step
  virtual void afterStep(const Simulation&, const StepContext&) = 0;
  virtual void end(const Simulation&) {}  ///< after the last step, also when the run diverged
  /// The files that it would write or replace now. The scene must not read them, no other observer may write them, and all
  /// must be writable before the first step. For a series: the existing files and the next one.
  virtual std::vector<std::string> files() const { return {}; }
  /// Files are written under a temporary name first, which needs a writable folder.
  virtual bool replacesFiles() const { return false; }
  /// False if it reads only the nodes of addWatchedNodes() after this step. Called before afterStep(), for integrators that
  /// update the other nodes on demand.
  virtual bool readsAllNodes(const StepContext&) const { return true; }
  /// Appends the nodes of `state` that it reads after steps for which readsAllNodes() is false.
  virtual void addWatchedNodes(const State& /*state*/, std::vector<Index>& /*nodes*/) const {}
  /// What it does and how often, for `explain`: "writes out.vtu every 10 steps".
  virtual std::string describe() const = 0;
};

}  // namespace stroma
