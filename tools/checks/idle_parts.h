// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/simulation/simulation.h"

namespace stroma {

/// Warns of what takes no part in the motion though whoever wrote the scene may think so: bodies of which every node is held
/// for good, constraints on nodes that others move, loads on held nodes, a gravity without a mass in statics, and cells that
/// no force field acts on, in meshes of more than one kind of volume cells (a law for one kind leaves the others out, and the
/// nodes that both have hide it). Notes two laws for the same cells, which add up.
void warnOfIdleParts(const Simulation& simulation, Diagnostics& diagnostics);

}  // namespace stroma
