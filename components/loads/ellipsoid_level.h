// SPDX-License-Identifier: LGPL-2.1-or-later
// How far a place is from an ellipsoid, to first order (ellipsoid_force_field.cpp has the formula).
#pragma once
#include <cmath>

#include "components/loads/penalty_field.h"

namespace stroma {

/// s, its gradient and second derivative: with a = y/r^2, b = y/r^4, grad q = 2 a, grad w = 2 b.
inline Depth levelOf(const Vec3& y, const Vec3& radii) {
  const Vec3 inverse = radii.array().square().inverse();
  const Vec3 a = y.cwiseProduct(inverse), b = a.cwiseProduct(inverse);
  const double q = y.dot(a), w = a.squaredNorm();
  const double root_q = std::sqrt(q), root_w = std::sqrt(w), slope = 2 - 1 / root_q;
  Depth level;
  level.g = (q - root_q) / root_w;
  level.gradient = (slope * a - (q - root_q) / w * b) / root_w;
  const Mat3 ab = a * b.transpose();
  const Mat3 inverse4 = inverse.array().square().matrix().asDiagonal();
  level.hessian = (slope * inverse.asDiagonal().toDenseMatrix() + a * a.transpose() / (q * root_q)) / root_w -
                  slope * (ab + ab.transpose()) / (w * root_w) -
                  (q - root_q) / (w * root_w) * (inverse4 - 3 / w * b * b.transpose());
  return level;
}

/// SOFA's: the number sqrt(q) - 1 along the unit normal a/|a|. What is no derivative of it makes up for the terms that a tangent
/// k (n n^T + g H) has besides: of SOFA's, which is not symmetric, H has the symmetric part.
inline Depth ratioOf(const Vec3& y, const Vec3& radii) {
  const Vec3 inverse = radii.array().square().inverse();
  const Vec3 a = y.cwiseProduct(inverse);
  const double root_q = std::sqrt(y.dot(a)), length = a.norm();
  Depth level;
  level.g = root_q - 1;
  level.gradient = a / length;
  const Mat3 pair = a * a.cwiseProduct(inverse).transpose() / (length * length);
  level.hessian = inverse.asDiagonal().toDenseMatrix() / length - (pair + pair.transpose()) / 2;
  if (level.g != 0) level.hessian += (length / root_q - 1) / level.g * level.gradient * level.gradient.transpose();
  return level;
}

}  // namespace stroma
