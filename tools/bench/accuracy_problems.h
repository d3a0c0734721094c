// SPDX-License-Identifier: LGPL-2.1-or-later
// The problems of the standing set: a scene, a quantity, and a reference that Stroma did not compute.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "framework/simulation/simulation.h"

namespace stroma::bench {

/// One way to compute it: a kind of element, a method, a setting.
struct Way {
  std::string name, scene;
  std::vector<std::string> settings;  ///< overrides
  std::vector<int> sizes;             ///< cells across; see Problem::mesh
};

struct Problem {
  std::string name, quantity, source;
  double reference = 0, uncertainty = 0;  ///< a share of it
  std::vector<std::string> (*mesh)(int cells) = nullptr;  ///< overrides
  double (*measure)(const Simulation&) = nullptr;
  std::vector<Way> ways{};
};

/// Problems at rest: one step of statics each.
std::vector<Problem> staticProblems();

}  // namespace stroma::bench
