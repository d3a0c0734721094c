// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <Eigen/Geometry>

#include "framework/mesh/mesh.h"

namespace stroma {

inline double tetrahedronVolume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return (b - a).cross(c - a).dot(d - a) / 6;
}

/// Length [m], area [m^2] or signed volume [m^3] of a simplex with nodes at x, shape (dimension + 1).
[[gnu::always_inline]] inline double simplexSize(int dimension, const Vec3* x) {
  if (dimension == 1) return (x[1] - x[0]).norm();
  if (dimension == 2) return 0.5 * (x[1] - x[0]).cross(x[2] - x[0]).norm();
  return tetrahedronVolume(x[0], x[1], x[2], x[3]);
}

}  // namespace stroma
