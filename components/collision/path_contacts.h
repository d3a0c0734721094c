// SPDX-License-Identifier: LGPL-2.1-or-later
// Contacts on the way of a step: where a point and a triangle, or two lines, first come near on straight paths.
#pragma once
#include "framework/collision/pair_distances.h"

namespace stroma::collision {

/// The fraction of the paths x + t way after which a pair is as near as `distance` [m], to a thousandth of it and a millionth of the size
/// of the pair; above 1: it stays farther. By conservative advancement: the distance decreases at most by the relative motion of the
/// two sides, so that a step of (d - distance)/speed is safe and no approach is missed.
double firstNear(PairKind kind, const FourPoints& x, const FourPoints& way, double distance);

}  // namespace stroma::collision
