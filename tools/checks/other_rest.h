// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "framework/simulation/simulation.h"

namespace stroma {

/// A sentence on a body that lies still with more energy than its rest shape has under the same loads, or empty: the
/// shape is then one of several that can be at rest, as a sheet is that has folded against its springs.
///
///   U(x) - U(X) + dU/ds > 0,   d/ds along the way from x to X
///
/// X is the rest shape and U the energy of all forces that have one, gravity's included. dU/ds is the work that the loads
/// without an energy, held as they are, would do on the way; where all forces have an energy it is zero, and the body
/// would not be at rest otherwise. What starts in its rest shape and is damped ends with less than U(X), however it folds:
/// cloth that hangs or lies in folds is not meant. Nothing is said where a load that follows the body has turned with it, where
/// work came from elsewhere (prescribed motions, inputs, loads over time), nor where X is not free to be taken.
std::string otherRest(const Simulation& simulation, std::size_t system);

}  // namespace stroma
