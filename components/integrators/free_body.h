// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "framework/simulation/system.h"

namespace stroma {

/// A sentence when something can be shifted or turned without any force resisting while its loads push it that way: it
/// has no equilibrium. Empty otherwise. `force` is the projected force of the last evaluation [N], shape
/// (independentRows()). A part is what the graph of the stiffness matrix connects, a state, less or more; parts that ties
/// and linear relations join make a cluster. What the six rigid motions T of its parts feel together is T^T A T, A the
/// stiffness with the constraints in force; motions of which that is nothing must do no work on the forces. In a cluster
/// of more than eight parts all move as one.
std::string freeBody(System& system, ConstRows force);

/// Grows when constraints turn, begin or end, and when springs and contacts come or go.
inline long revisionOfHolds(const System& system) {
  return system.constraints().revision() + system.actors().patternRevision();
}

}  // namespace stroma
