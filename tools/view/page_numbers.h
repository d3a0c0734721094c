// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "tools/session/mesh_changes.h"
#include "tools/view/drawn.h"

namespace stroma::view {

/// Where the nodes known to pages have moved while meshes changed. A page gets the new drawing only with its next frame,
/// after several changes perhaps. Bodies are known by the paths of their states.
class PageNumbers {
 public:
  explicit PageNumbers(const Drawing& drawing) { told(drawing, 0); }

  /// Meshes have changed; `drawing` is that of the scene now.
  void follow(const Drawing& drawing, const NodesNow& now);
  /// Pages know this drawing, by the number of its scene.
  void told(const Drawing& drawing, int generation);
  bool isUntold() const { return untold_; }
  int toldGeneration() const { return generation_; }
  /// Of each page number of a body, the page number that pages know, or -1.
  std::vector<std::int32_t> before(const Body& body) const;
  /// The way back to the first scene: of each node now, its number there, or -1. States are named whose meshes have changed.
  const NodesNow& firstNodes() const { return first_; }
  /// The scene is the first one again.
  void restart() { first_.clear(); }

 private:
  std::map<std::string, std::vector<Index>> known_;  ///< of each row now
  NodesNow first_;
  int generation_ = 0;
  bool untold_ = false;
};

}  // namespace stroma::view
