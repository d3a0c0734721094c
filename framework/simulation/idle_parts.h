// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/scene/diagnostics.h"
#include "framework/simulation/system.h"

namespace stroma {

/// Warns of each body of which every node is held for good: nothing of it can move.
void warnOfHeldBodies(const System& system, Diagnostics& diagnostics);

/// Warns of cells that no force field acts on, in meshes of more than one kind of volume cells: a law for one kind leaves
/// the others out, and the nodes that both have hide it.
void warnOfCellsWithoutLaw(const System& system, const Node& root, Diagnostics& diagnostics);

}  // namespace stroma
