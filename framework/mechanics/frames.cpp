// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/mechanics/frames.h"

#include <cmath>

namespace stroma {

Quaternion turnedBy(const Vec3& r) {
  const double angle = r.norm();
  // sin(a/2)/a = 1/2 - a^2/48 + a^4/3840
  const double square = angle * angle;
  const double factor = angle < 1e-2 ? 0.5 - square / 48 + square * square / 3840 : std::sin(angle / 2) / angle;
  Quaternion q;
  q.vec() = factor * r;
  q.w() = std::cos(angle / 2);
  return q;
}

Vec3 rotationVector(const Quaternion& q) {
  const double sine = q.vec().norm();
  if (sine == 0) return Vec3::Zero();
  const double sign = q.w() < 0 ? -1 : 1;
  return sign * 2 * std::atan2(sine, std::abs(q.w())) / sine * q.vec();
}

void placeRow(RowKind kind, const Vec3& value, Rows x, Index row) {
  x[row] = value;
  if (kind != RowKind::turn) return;
  Eigen::Map<Quaternion> q(x.data + std::size_t(row) * row_doubles);
  q = turnedBy(value);
  if (q.w() < 0) q.coeffs() = -q.coeffs();
}

Vec3 valueOfRow(RowKind kind, ConstRows x, Index row) {
  return kind == RowKind::turn ? rotationVector(orientationIn(x, row)) : Vec3(x[row]);
}

Mat3 dexpInverse(const Vec3& r) {
  const double angle = r.norm(), half = angle / 2;
  // (1 - a/2 cot(a/2)) / a^2 = 1/12 + a^2/720 + a^4/30240
  const double c = angle < 1e-2 ? 1. / 12 + angle * angle / 720 : (1 - half / std::tan(half)) / (angle * angle);
  const Mat3 cross = crossMatrix(r);
  return Mat3::Identity() - 0.5 * cross + c * cross * cross;
}

}  // namespace stroma
