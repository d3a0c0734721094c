// SPDX-License-Identifier: LGPL-2.1-or-later
// An exact test whether a segment and a triangle share a point. Signs of determinants are decided by a bound on their
// round-off, and if that is not enough by exact sums of doubles (Shewchuk 1997).
#pragma once
#include "framework/scene/types.h"

namespace stroma {

/// The sign of (a - d) x (b - d) . (c - d): 1, 0 or -1. Exact while the non-zero differences of coordinates span fewer
/// than 90 orders of magnitude.
int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// Both sets are closed: touching counts. Segments may lie in the plane of the triangle, and triangles may be degenerate.
bool segmentMeetsTriangle(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace stroma
