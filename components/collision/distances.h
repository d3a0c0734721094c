// SPDX-License-Identifier: LGPL-2.1-or-later
// The distance of two simplices of one (a point), two (a segment) or three (a triangle) corners. Degenerate ones (of no
// length, of no area) reduce to the simplex that remains.
#pragma once
#include <span>

#include "framework/scene/types.h"

namespace stroma {

/// [m]; zero where the two cross, which is decided exactly.
double distanceOf(std::span<const Vec3> a, std::span<const Vec3> b);

}  // namespace stroma
