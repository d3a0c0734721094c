// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cmath>

#include "framework/mechanics/frames.h"

namespace stroma {

/// The twist of q about the unit vector e, and its derivative by a turn in the axes that q turns from.
struct Twist {
  double angle;
  Vec3 by_turn;
  Mat3 curve;  ///< derivative of by_turn
  Twist(const Quaternion& q, const Vec3& e) {
    const double w = q.w(), s = q.vec().dot(e), d = w * w + s * s;
    const Vec3 v = q.vec(), above = w * w * e + w * v.cross(e) + s * v;
    angle = 2 * std::atan2(s, w);
    by_turn = above / d;
    for (int k = 0; k < 3; ++k) {
      const Vec3 turn = Vec3::Unit(k), dv = 0.5 * (w * turn + turn.cross(v));
      const double dw = -0.5 * turn.dot(v), ds = dv.dot(e);
      const Vec3 change = 2 * w * dw * e + dw * v.cross(e) + w * dv.cross(e) + ds * v + s * dv;
      curve.col(k) = change / d - above * (2 * s * ds + 2 * w * dw) / (d * d);
    }
  }
};

}  // namespace stroma
