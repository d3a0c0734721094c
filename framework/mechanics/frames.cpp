// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/mechanics/signs.h"

#include <cmath>
#include <numbers>
#include <utility>

namespace stroma {

namespace {

/// sin(a/2)/a and cos(a/2) of s = a^2: their series where the first left-out term is below 1e-17, as of most steps.
std::pair<double, double> halfAngle(double s) {
  if (s < 0.06) {
    const double z = s / 4;
    return {0.5 - z * (1. / 12 - z * (1. / 240 - z * (1. / 10080 - z * (1. / 725760 - z / 79833600)))),
            1 - z * (1. / 2 - z * (1. / 24 - z * (1. / 720 - z * (1. / 40320 - z * (1. / 3628800 - z / 479001600)))))};
  }
  const double angle = std::sqrt(s);
  return {std::sin(angle / 2) / angle, std::cos(angle / 2)};
}

}  // namespace

Quaternion turnedBy(const Vec3& r) {
  const auto [factor, cosine] = halfAngle(r.squaredNorm());
  return Quaternion(cosine, factor * r.x(), factor * r.y(), factor * r.z());
}

Vec3 rotationVector(const Quaternion& q) {
  const double square = q.vec().squaredNorm(), sign = q.w() < 0 ? -2 : 2;
  if (square < 0.01) {  // asin(s)/s, of which the first term that is left out is below 1e-17
    double sum = 0;
    for (const double c : {143. / 10240, 231. / 13312, 63. / 2816, 35. / 1152, 5. / 112, 3. / 40, 1. / 6, 1.}) sum = sum * square + c;
    return sign * sum * q.vec();
  }
  const double sine = std::sqrt(square);
  return sign * std::atan2(sine, std::abs(q.w())) / sine * q.vec();
}

Vec3 signedRotationVector(const Quaternion& q) {
  const Vec3 shortest = rotationVector(q);
  if (!(q.w() < 0)) return shortest;
  constexpr double whole_turn = 2 * std::numbers::pi, nothing = 1e-150;
  const double angle = shortest.norm();
  return angle > nothing ? Vec3((1 - whole_turn / angle) * shortest) : Vec3(whole_turn, 0, 0);
}

void putOrientation(const Quaternion& q, Rows x, Index row) {
  Eigen::Map<Quaternion>(x.data + std::size_t(row) * row_doubles) = q;
}

void putNearest(const Quaternion& q, Rows x, Index row) {
  Eigen::Map<Quaternion> to(x.data + std::size_t(row) * row_doubles);
  to.coeffs() = to.dot(q) < 0 ? -q.coeffs() : q.coeffs();
}

void placeRow(RowKind kind, const Vec3& value, Rows x, Index row) {
  if (kind == RowKind::turn)
    putOrientation(turnedBy(value), x, row);
  else
    x[row] = value;
}

Vec3 valueOfRow(RowKind kind, ConstRows x, Index row) {
  return kind == RowKind::turn ? signedRotationVector(orientationIn(x, row)) : Vec3(x[row]);
}

Mat3 dexpInverse(const Vec3& r) {
  const double angle = r.norm(), half = angle / 2;
  // (1 - a/2 cot(a/2)) / a^2 = 1/12 + a^2/720 + a^4/30240
  const double c = angle < 1e-2 ? 1. / 12 + angle * angle / 720 : (1 - half / std::tan(half)) / (angle * angle);
  const Mat3 cross = crossMatrix(r);
  return Mat3::Identity() - 0.5 * cross + c * cross * cross;
}

}  // namespace stroma
