// SPDX-License-Identifier: LGPL-2.1-or-later
// What changes of meshes have made of the description of a scene, as values of a checkpoint.
#pragma once
#include "framework/scene/archive.h"
#include "framework/scene/description.h"

namespace stroma {

/// The nodes of a tree whose components are others than in `first`. Of each component that is as it was there is only its number.
/// Values that a program gave are written as text.
void writeChangedNodes(const NodeDescription& first, const NodeDescription& now, Archive& archive);

/// Makes `root`, which was `first`, the tree that was written. Throws std::runtime_error with a sentence when what a change has
/// rewritten is not as it was then; `root` is then of no use.
void readChangedNodes(Archive& archive, NodeDescription& root);

}  // namespace stroma
