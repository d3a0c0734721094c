// SPDX-License-Identifier: LGPL-2.1-or-later
// What is in a scene before it is complete.
#pragma once
#include <memory>
#include <string>

#include "framework/scene/load.h"

namespace stroma {

/// The components of a description with their attributes and links. None is initialised before it is asked for, and what is
/// wrong with others does not matter to it: a loader has read its file, a region has found its nodes, in a scene that has no
/// integrator yet. Nothing of it runs.
class Preview {
 public:
  /// Modules and factory outlive it.
  Preview(SceneDescription description, Factory& factory, Modules& modules);
  Preview(const Preview&) = delete;

  Node& root() const { return *scene_.root; }
  /// Null when there is none.
  Component* find(const std::string& path) const { return findComponent(root(), path); }
  /// Runs init() of the component and of what it needs, once. False when that failed: problems() has the reason.
  bool ready(Component& component);
  /// All that was found so far.
  const Diagnostics& problems() const { return scene_.diagnostics; }

 private:
  Scene scene_;
};

}  // namespace stroma
