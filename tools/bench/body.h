// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "framework/simulation/simulation.h"
#include "tools/bench/figure.h"

namespace stroma::bench {

/// The folder that holds benchmarks/, examples/ and meshes/: the one given, else beside the installed program, else the
/// source tree's.
std::string sceneFolder();
void setSceneFolder(const std::string& folder);

/// The folder of this program; `stroma` lies beside it.
std::string programFolder();

/// A piece of a scene's text that stands there once, and what takes its place.
using Replacement = std::pair<std::string, std::string>;

/// A scene ready to run; no observer writes anything. `scene` is relative to sceneFolder(). Throws SceneError, and
/// std::runtime_error for a piece that is not there.
std::unique_ptr<Simulation> loadSimulation(const std::string& scene, const std::vector<std::string>& overrides,
                                           const std::vector<Replacement>& replacements = {});

/// A simulation past its first steps, in which all is computed on demand. The last one asked for is kept, as bodies are: `name` says
/// which it is.
Simulation& keptSimulation(const std::string& name, int first_steps, const std::string& scene, const std::vector<std::string>& overrides,
                           const std::vector<Replacement>& replacements = {});

/// Of the direct solvers of a simulation that has made a step: a factorisation each, its factors written once, and read
/// by one solve from front to back and from back to front.
Work factorWork(const Simulation& simulation);

/// The shape on which kernels are timed.
enum class Shape {
  deformed,  ///< twisted by two radians along x, nodes moved at random by up to a tenth of their distance
  crumpled,  ///< nodes moved by up to six tenths of it: many elements are inverted
};

/// The one elastic body of a scene with everything a kernel call needs; the force has been evaluated once at `x`.
struct Body {
  Body(const std::string& scene, const std::vector<std::string>& overrides, Shape shape);
  std::unique_ptr<Simulation> simulation;
  System* system = nullptr;
  ForceField* field = nullptr;
  Vector x, v, dx, f, df;
  double elements = 0;
  double invertedShare() const;  ///< elements with J < 0 at x, of all
};

/// The last body asked for is kept: repetitions of one benchmark share it.
Body& bodyOf(const std::string& scene, const std::vector<std::string>& overrides, Shape shape);

}  // namespace stroma::bench
