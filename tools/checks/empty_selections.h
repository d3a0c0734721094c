// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/scene/diagnostics.h"
#include "framework/scene/node.h"

namespace stroma {

/// Warns of each list of nodes or cells that a component which acts or writes was given, and that is empty: a box that
/// misses its nodes, a mesh without edges. A list that was not given is none of them.
void warnOfEmptySelections(const Node& root, Diagnostics& diagnostics);

}  // namespace stroma
