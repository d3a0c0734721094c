// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "framework/simulation/system.h"

namespace stroma {

/// A message if some part can translate or rotate without resistance while its loads push it that way, so that it has no
/// equilibrium; otherwise empty. `force` is the projected force of the last evaluation [N], shape (independentRows()). A
/// part is a connected component of the stiffness graph, which may be a whole state, less or more; parts joined by ties and
/// linear relations form a cluster. The stiffness of its six rigid motions T per part is T^T A T, with the constrained
/// stiffness A. Forces must do no work on motions in its null space. In a cluster of more than eight parts all move
/// together.
std::string freeBody(System& system, ConstRows force);

/// Increases when constraints change direction, begin or end, and when springs and contacts appear or disappear.
inline long revisionOfHolds(const System& system) {
  return system.constraints().revision() + system.actors().patternRevision();
}

}  // namespace stroma
