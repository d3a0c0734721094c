// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "tools/view/body.h"

namespace stroma::view {

/// What plots want to know, by the words of the page's message "watch". Nothing is computed that no word asks for.
class WatchedValues {
 public:
  WatchedValues(const Simulation& simulation, const Drawing& drawing) : simulation_(simulation), drawing_(drawing) {}

  /// Throws ComponentError when `word` is none that can be watched: "energy", "solver", or "node.BODY.NODE.position",
  /// ".velocity" or ".reaction" with the node's number in the scene.
  void check(const std::string& word) const;
  /// Values by name ("energy.kinetic", "node.0.12.position.x") at the present state.
  nlohmann::json read(const std::set<std::string>& words, const StepReport& last, double step_ms) const;

 private:
  struct NodeWord {
    const Body* body;
    Index row;  ///< in the system
    std::string what;
  };
  NodeWord nodeOf(const std::string& word) const;
  /// Minus the sum of all forces on the row [N]: what a constraint adds to hold it, in statics and where it stands still.
  Vec3 reaction(const System& system, Index row) const;

  const Simulation& simulation_;
  const Drawing& drawing_;
  mutable Vector forces_;
};

}  // namespace stroma::view
