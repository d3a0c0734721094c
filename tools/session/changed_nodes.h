// SPDX-License-Identifier: LGPL-2.1-or-later
// Stores the changes that mesh edits have made to the description of a scene as values of a checkpoint.
#pragma once
#include "framework/scene/archive.h"
#include "framework/scene/description.h"

namespace stroma {

/// Writes the nodes of a tree whose components differ from `first`. Unchanged components are stored by number only. Values
/// passed by a program are written as text.
void writeChangedNodes(const NodeDescription& first, const NodeDescription& now, Archive& archive);

/// Turns `root`, initially equal to `first`, into the stored tree. Throws std::runtime_error if a rewritten part differs from
/// the original; `root` is then unusable.
void readChangedNodes(Archive& archive, NodeDescription& root);

}  // namespace stroma
