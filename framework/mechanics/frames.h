// SPDX-License-Identifier: LGPL-2.1-or-later
// Orientations as unit quaternions q (x, y, z, w), and rotation vectors r: axis times angle [rad], in fixed axes.
#pragma once
#include <Eigen/Geometry>

#include "framework/mechanics/state.h"

namespace stroma {

using Quaternion = Eigen::Quaterniond;  // coefficients x, y, z, w as in a row

/// exp(r) = (sin(|r|/2) r/|r|, cos(|r|/2))
Quaternion turnedBy(const Vec3& r);
/// log(q), the shortest rotation vector of q.
Vec3 rotationVector(const Quaternion& q);
/// The orientation in a row of positions.
inline Quaternion orientationIn(ConstRows x, Index row) { return Quaternion(x.data + std::size_t(row) * row_doubles); }
/// Writes a value in the form of State::position to a row of positions.
void placeRow(RowKind kind, const Vec3& value, Rows x, Index row);
/// The inverse of that.
Vec3 valueOfRow(RowKind kind, ConstRows x, Index row);
/// Writes an orientation to a row of positions; of q and -q the one given (signs.h).
void putOrientation(const Quaternion& q, Rows x, Index row);
/// [r]: [r] a = r x a
inline Mat3 crossMatrix(const Vec3& r) {
  Mat3 m;
  m << 0, -r.z(), r.y(), r.z(), 0, -r.x(), -r.y(), r.x(), 0;
  return m;
}
/// The inverse of dexp at r: w = r' of exp(r(t)) q turning with the angular velocity w, r' = dexpInverse(r) w.
///   I - [r]/2 + c [r]^2,   c = (1 - |r|/2 cot(|r|/2)) / |r|^2
Mat3 dexpInverse(const Vec3& r);

}  // namespace stroma
