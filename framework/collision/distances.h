// SPDX-License-Identifier: LGPL-2.1-or-later
// Nearest points of points, segments and triangles. Degenerate ones (of no length, of no area) are what is left of them.
// Source: C. Ericson, Real-Time Collision Detection (2005), sections 5.1.5 and 5.1.9.
#pragma once
#include <span>

#include "framework/scene/types.h"

namespace stroma {

Vec3 nearestOnSegment(const Vec3& p, const Vec3& a, const Vec3& b);
Vec3 nearestOnTriangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

/// The distance of two things of one (a point), two (a segment) or three (a triangle) corners [m]; zero where they
/// cross.
double distanceOf(std::span<const Vec3> a, std::span<const Vec3> b);

/// Whether the segment from p to q goes through the triangle.
bool crosses(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace stroma
