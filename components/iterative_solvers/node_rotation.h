// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <Eigen/Geometry>
#include <cmath>

#include "framework/scene/types.h"

namespace stroma {

/// Turns q to the rotation nearest to A (largest trace of R^T A), from the q given (Mueller, Bender, Chentanez, Macklin
/// 2016): works for any A, also one that inverts or has lost a rank. Ends with a turn below `enough` [rad].
inline void followRotation(const Mat3& a, Eigen::Quaterniond& q, double enough = 1e-7) {
  for (int i = 0; i < 10; ++i) {
    const Mat3 r = q.toRotationMatrix();
    const Vec3 axis = r.col(0).cross(a.col(0)) + r.col(1).cross(a.col(1)) + r.col(2).cross(a.col(2));
    const double scale = std::abs((r.transpose() * a).trace()) + 1e-9 * a.norm();
    if (!(scale > 0)) return;
    const double angle = axis.norm() / scale;
    if (!(angle > enough)) return;
    q = Eigen::AngleAxisd(angle, axis.normalized()) * q;
    q.normalize();
  }
}

}  // namespace stroma
