// SPDX-License-Identifier: LGPL-2.1-or-later
// The problems of the standing set: a scene, a quantity, and a reference that Stroma did not compute.
#pragma once
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "framework/simulation/simulation.h"
#include "tools/bench/body.h"

namespace stroma::bench {

/// One way to compute it: a kind of element, a method, a solver, a setting.
struct Way {
  std::string name, scene;
  std::vector<std::string> settings;  ///< overrides
  std::vector<int> sizes;             ///< cells across; see Problem::mesh. 0: the mesh of the scene
  int steps = 1;
  std::vector<Replacement> parts{};  ///< of the scene's text
};

struct Problem {
  std::string name, quantity, source;
  double reference = 0, uncertainty = 0;  ///< a share of it
  double size = 0;  ///< of a distance from what was measured: its error is a share of this. 0: of the reference
  std::string left_out{};  ///< why it cannot be solved here
  std::vector<std::string> (*mesh)(int cells) = nullptr;  ///< overrides
  std::function<double(const Simulation&)> measure{};
  std::vector<Way> ways{};
};

/// Problems whose quantity is one number at the end. `beads`: the file of the truth cube's measured beads, or empty. Throws
/// std::runtime_error when it is none.
std::vector<Problem> staticProblems(const std::string& beads);

}  // namespace stroma::bench
