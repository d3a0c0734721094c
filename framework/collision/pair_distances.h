// SPDX-License-Identifier: LGPL-2.1-or-later
// Distances of a point from a triangle and of two edges, with derivatives. The difference of the closest points of a
// pair of four points is
//   D = sum c_i x_i,   d = |D|,   n = D / d,   grad_i d = c_i n
// The points of a point and a triangle are p, a, b, c with c = (1, -u, -v, -w); those of two edges are a0, a1, b0, b1 with
// c = (1 - s, s, t - 1, -t). If c_i is zero, the closest feature does not contain point i.
#pragma once
#include <array>

#include "framework/scene/types.h"

namespace stroma {

enum class PairKind : unsigned char { point_triangle, edge_edge };
using FourPoints = std::array<Vec3, 4>;

struct ClosestPoints {
  std::array<double, 4> weights;  ///< c_i
  Vec3 difference;                ///< D [m]; its direction is accurate even if it is far shorter than the pair
  double distance() const { return difference.norm(); }
  /// How many of the four points take part: 2: two points; 3: a point and an edge; 4: a point over a triangle, or two
  /// crossing edges.
  int points() const { return (weights[0] != 0) + (weights[1] != 0) + (weights[2] != 0) + (weights[3] != 0); }
};

/// Any input is valid: slivers, parallel edges, coincident points. The error of the distance is below
/// 1e-12 of the largest distance between two of the points; nearly flat triangles and nearly parallel edges have 113 bits.
ClosestPoints closestPoints(PairKind kind, const FourPoints& x);

/// Tends to 0 as two edges become parallel and the direction of their distance becomes undefined (Li et al. 2020):
///   m = (2 - q/e) q/e for q < e, else 1;   q = |ea x eb|^2, e = 1e-3 |ea at rest|^2 |eb at rest|^2
double parallelFactor(const Vec3& ea, const Vec3& eb, double rest_squares);

}  // namespace stroma
