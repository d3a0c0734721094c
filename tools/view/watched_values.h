// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>

#include "tools/view/drawn.h"

namespace stroma::view {

/// What plots want to know, by the words of the page's message "watch". Nothing is computed that no word asks for.
class WatchedValues {
 public:
  WatchedValues(const Simulation& simulation, const Drawing& drawing) : simulation_(simulation), drawing_(drawing) {}

  /// Throws ComponentError when `word` is none that can be watched: "energy", "solver", or "node.BODY.NODE.position",
  /// ".velocity" or ".reaction" with the node's number in the scene.
  void check(const std::string& word) const;
  /// Values by name ("energy.kinetic", "node.0.12.position.x") at the present state. Words that are none (any more) have no value.
  /// Energies and reactions, which cost a pass over all elements, are left out where they would take more than a hundredth of the
  /// time, unless nothing moves (`still`).
  nlohmann::json read(const std::set<std::string>& words, const StepReport& last, double step_ms, bool still);

 private:
  struct NodeWord {
    const Body* body;
    Index row;  ///< in the state
    std::string what;
  };
  /// None: there is no such node, or the word is none of these.
  std::optional<NodeWord> find(const std::string& word) const;
  /// Minus the sum of all forces on the row [N]: what a constraint adds to hold it, in statics and where it stands still.
  /// The forces of all rows of a system are computed once for all words of a read().
  Vec3 reaction(const Body& body, Index row);

  const Simulation& simulation_;
  const Drawing& drawing_;
  Vector forces_;
  const System* forces_of_ = nullptr;  ///< whose forces_ are those of this read()
  std::chrono::steady_clock::time_point due_{};
};

}  // namespace stroma::view
