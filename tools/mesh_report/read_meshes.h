// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/scene/node.h"

namespace stroma {

/// While it lives, a mesh loader that is made in this thread, and has all attributes of the one at its path in the tree of
/// `root`, takes what that one has read: a reloaded scene reads no file again, and finds it unchanged.
class ReadMeshes {
 public:
  explicit ReadMeshes(Node& root);
  ReadMeshes(const ReadMeshes&) = delete;
  ~ReadMeshes();

 private:
  Node* before_;  ///< of the one around it
};

}  // namespace stroma
