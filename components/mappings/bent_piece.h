// SPDX-License-Identifier: LGPL-2.1-or-later
// A piece of a rod of length l whose strains are the same everywhere: the curvature k, and the axis a along which it goes on, which is
// x where it neither stretches nor shears. Its end seen from its start, and how that moves with them. With the turn theta = l k and
// phi = |theta|,
//
//   rotation exp [theta],   way d = l V a,   V = I + b1 [theta] + b2 [theta]^2
//   b1 = (1 - cos phi)/phi^2,   b2 = (phi - sin phi)/phi^3
//
// The end turns with V theta' and moves with d' = l V' a + l V a'. Derivatives by phi:
// c1 = b1'/phi, c2 = b2'/phi, g1 = c1'/phi, g2 = c2'/phi.
#pragma once
#include <Eigen/Geometry>
#include <cmath>

#include "framework/mechanics/frames.h"

namespace stroma {

struct BentPiece {
  double length = 0;         ///< l [m]
  Vec3 turn = Vec3::Zero();  ///< theta [rad]
  Vec3 axis = Vec3::UnitX();  ///< a
  double b1 = 0.5, b2 = 1. / 6, c1 = -1. / 12, c2 = -1. / 60, g1 = 1. / 90, g2 = 1. / 630;

  BentPiece() = default;
  BentPiece(double l, const Vec3& curvature, const Vec3& along = Vec3::UnitX()) : length(l), turn(l * curvature), axis(along) {
    const double square = turn.squaredNorm();
    constexpr double series_below = 1;
    if (square < series_below)
      bySeries(square);
    else
      byFunctions(std::sqrt(square));
  }

  Mat3 spin() const {  ///< V
    const Mat3 cross = crossMatrix(turn);
    return Mat3::Identity() + b1 * cross + b2 * cross * cross;
  }
  Vec3 way() const {
    return length * (axis + b1 * turn.cross(axis) + b2 * turn.cross(turn.cross(axis)));
  }
  /// l V' v for theta' = r; d' where v is a.
  Vec3 wayBy(const Vec3& r, const Vec3& v) const {
    const Vec3 once = turn.cross(v);
    const double along = turn.dot(r);
    return length * (b1 * r.cross(v) + b2 * (r.cross(once) + turn.cross(r.cross(v))) + along * (c1 * once + c2 * turn.cross(once)));
  }
  /// l V'' a for a constant theta' = r.
  Vec3 wayTwiceBy(const Vec3& r) const {
    const Vec3 once = turn.cross(axis), moved = r.cross(axis);
    const double along = turn.dot(r), square = r.squaredNorm();
    const double b1_twice = g1 * along * along + c1 * square, b2_twice = g2 * along * along + c2 * square;
    return length * (b1_twice * once + 2 * c1 * along * moved + b2_twice * turn.cross(once) +
                     2 * c2 * along * (r.cross(once) + turn.cross(moved)) + 2 * b2 * r.cross(moved));
  }
  /// V' r for a constant theta' = r.
  Vec3 spinTwiceBy(const Vec3& r) const {
    const Vec3 across = turn.cross(r);
    return b2 * r.cross(across) + turn.dot(r) * (c1 * across + c2 * turn.cross(across));
  }

 private:
  /// b1 = sum (-1)^n phi^(2n) / (2n+2)!, b2 with (2n+3)!, and their derivatives term by term.
  void bySeries(double square) {
    b1 = b2 = c1 = c2 = g1 = g2 = 0;
    double power[3] = {1, 0, 0}, one = 1. / 2, other = 1. / 6;  // phi^(2n), phi^(2n-2), phi^(2n-4)
    constexpr int terms = 10;
    for (int n = 0; n < terms; ++n) {
      const double first = 2 * n, second = 2 * n * (2 * n - 2);
      b1 += one * power[0], b2 += other * power[0];
      c1 += one * first * power[1], c2 += other * first * power[1];
      g1 += one * second * power[2], g2 += other * second * power[2];
      one /= -(2. * n + 3) * (2. * n + 4), other /= -(2. * n + 4) * (2. * n + 5);
      power[2] = power[1], power[1] = power[0], power[0] *= square;
    }
  }
  void byFunctions(double phi) {
    const double s = std::sin(phi), c = std::cos(phi), square = phi * phi;
    b1 = (1 - c) / square, b2 = (phi - s) / (square * phi);
    c1 = (s / phi - 2 * b1) / square, c2 = (b1 - 3 * b2) / square;
    g1 = ((c - s / phi) / square - 4 * c1) / square, g2 = (c1 - 5 * c2) / square;
  }
};

}  // namespace stroma
