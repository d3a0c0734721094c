// SPDX-License-Identifier: LGPL-2.1-or-later
// One case, from loading the scene to what became of it. It runs in a process of its own.
#pragma once
#include <string>
#include <vector>

#include "tools/stress/outcome.h"

namespace stroma::stress {

/// What all cases of a scene share.
struct Scenery {
  std::string scene;
  std::vector<Override> overrides;
  std::vector<std::string> modules;
  long steps = 0;
};

/// The undisturbed run.
struct Undisturbed {
  std::string failure;  ///< why it has no result, or empty
  std::vector<std::string> doubts;
  std::uint64_t hash = 0;         ///< of its last state
  double seconds = 0;             ///< of processor time, loading included
  std::vector<double> positions;  ///< x y z of each row of all systems at the end
};
Undisturbed runUndisturbed(const Scenery& scenery);

/// Does not throw: whatever comes is an outcome.
Outcome runCase(const Scenery& scenery, const Case& what, const Undisturbed& undisturbed);

}  // namespace stroma::stress
