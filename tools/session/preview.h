// SPDX-License-Identifier: LGPL-2.1-or-later
// Access to the components of an incomplete scene.
#pragma once
#include <memory>
#include <string>

#include "framework/scene/load.h"

namespace stroma {

/// The components of a description with their attributes and links. Each is initialised on demand, independently of problems
/// elsewhere: a loader can read its file, and a region can find its nodes, in a scene that has no integrator
/// yet. Nothing runs.
class Preview {
 public:
  /// Modules and factory must outlive this object.
  Preview(SceneDescription description, Factory& factory, Modules& modules);
  Preview(const Preview&) = delete;

  Node& root() const { return *scene_.root; }
  /// Null if there is none.
  Component* find(const std::string& path) const { return findComponent(root(), path); }
  /// Runs init() of the component and its dependencies, once. Returns false if that failed: problems() has the reason.
  bool ready(Component& component);
  /// All problems found so far.
  const Diagnostics& problems() const { return scene_.diagnostics; }

 private:
  Scene scene_;
};

}  // namespace stroma
