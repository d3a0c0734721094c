// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "framework/simulation/system.h"

namespace stroma {

/// A sentence when some body can be shifted or turned as a whole without any force resisting while its loads push it
/// that way: it has no equilibrium. Empty otherwise. `force` is the projected force of the last evaluation [N], shape
/// (independentRows()). A body is a connected part of the graph of the stiffness matrix, a state or less (or more:
/// states tied together). What its six rigid motions T feel is T^T A T, A the stiffness with the constraints in force;
/// motions of which that is nothing must do no work on the forces.
std::string freeBody(System& system, ConstRows force);

}  // namespace stroma
