// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "framework/mechanics/state.h"
#include "framework/scene/component.h"
#include "framework/simulation/step.h"

namespace stroma {

class Simulation;

/// Reads after a step and changes nothing. Values that no observer asks for are not computed.
class Observer : public Component {
 public:
  std::string roleText() const override { return "observer"; }
  /// Called at load, when everything that moves is compiled: rejects what begin() or afterStep() could not do. Writes
  /// nothing. Throws ComponentError.
  virtual void compile(const Simulation&) {}
  virtual void begin(const Simulation&) {}  ///< at t = 0, before the first step
  virtual void afterStep(const Simulation&, const StepContext&) = 0;
  virtual void end(const Simulation&) {}  ///< after the last step, also when the run diverged
  /// The files that it writes, or replaces, as it stands now: what the scene reads must not be among them, nor what another
  /// observer writes, and all must be writable before the first step. Of a series, those that are there and the next.
  virtual std::vector<std::string> files() const { return {}; }
  /// They are written under another name first, which needs a writable folder.
  virtual bool replacesFiles() const { return false; }
  /// False when after this step it reads no other nodes than those of addWatchedNodes(). Asked before afterStep(), for
  /// integrators that bring the others to the present only when somebody reads them.
  virtual bool readsAllNodes(const StepContext&) const { return true; }
  /// Appends the nodes of `state` that it reads after steps for which readsAllNodes() is false.
  virtual void addWatchedNodes(const State& /*state*/, std::vector<Index>& /*nodes*/) const {}
  /// What it will do and how often, for `explain`: "writes out.vtu every 10 steps".
  virtual std::string describe() const = 0;
};

}  // namespace stroma
