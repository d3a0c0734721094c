// SPDX-License-Identifier: LGPL-2.1-or-later
// Nodes put elsewhere, as no step would put them.
#pragma once
#include <vector>

#include "tools/stress/cases.h"

namespace stroma::stress {

/// What can be put elsewhere in a scene.
struct Reach {
  bool places = false;   ///< nodes that are free to move
  bool corners = false;  ///< of cells with a volume
  bool held = false;     ///< nodes that are not
};
Reach reachOf(const Simulation& simulation);

/// Puts the free nodes of all bodies where `shape` says; what an integrator has computed beforehand (a condensed body) stays,
/// and so do orientations and numbers. Mapped states follow. False when nothing could be moved.
bool disturb(const Simulation& simulation, Shape shape, double amount, unsigned seed);

/// Moves all that is held in some direction by `amount` sizes of its body along one way, which the seed gives; a negative
/// amount moves it back. False when nothing is held.
bool moveHeld(const Simulation& simulation, double amount, unsigned seed);

/// The diagonal of the box of a system's places [m]; 1 without an extent.
double sizeOf(const System& system);

/// A node that is free to move, by chance: system and row. None when nothing is.
struct FreeRow {
  System* system = nullptr;
  Index row = 0;
};
FreeRow freeRow(const Simulation& simulation, unsigned seed);

}  // namespace stroma::stress
