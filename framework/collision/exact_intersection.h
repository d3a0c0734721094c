// SPDX-License-Identifier: LGPL-2.1-or-later
// Whether a segment and a triangle have a point in common, without error. Signs of determinants are decided by a bound
// on their round-off, and where that does not suffice by sums of doubles that are exact (Shewchuk 1997).
#pragma once
#include "framework/scene/types.h"

namespace stroma {

/// The sign of (a - d) x (b - d) . (c - d): 1, 0 or -1. Exact while the non-zero differences of coordinates span fewer
/// than 90 orders of magnitude.
int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// Closed sets: touching is meeting. Segments may lie in the plane of the triangle, triangles may be degenerate.
bool segmentMeetsTriangle(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace stroma
