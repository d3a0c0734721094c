// SPDX-License-Identifier: LGPL-2.1-or-later
// What a surface of triangles and bilinear quads sums its areas and volumes from. The area vector of node a of a face
//   A_a = integral of N_a n dA
// is what a pressure of 1 does there. For a triangle A_a = (x_1 - x_0) x (x_2 - x_0) / 6. For a quad, with the
// parameters -1 <= s, t <= 1 and corners at (s_a, t_a) = (-1,-1), (1,-1), (1,1), (-1,1),
//   x = m + s p + t q + s t r,   A_a = p x q + s_a/3 p x r + t_a/3 r x q
// also where the quad is warped. The volume behind a closed surface is V = 1/3 sum x_a . A_a, and dV/dx_a = sum A_a
// over the faces at the node.
#pragma once
#include <Eigen/Geometry>
#include <array>

#include "framework/scene/types.h"

namespace stroma {

/// A triangle or a quad; a triangle repeats its last node.
struct Face {
  std::array<Index, 4> nodes;
  int corners;
  Face(const Triangle& t) : nodes{t[0], t[1], t[2], t[2]}, corners(3) {}
  Face(const Quad& q) : nodes(q), corners(4) {}
};

namespace area_vectors {

using Corners = std::array<Vec3, 4>;     ///< positions or area vectors, of a triangle the first three
using Gradients = std::array<Vec3, 16>;  ///< w_ab at 4 a + b

constexpr double corner_s[4] = {-1, 1, 1, -1}, corner_t[4] = {-1, -1, 1, 1};

/// p, q, r of a quad.
struct Bilinear {
  Vec3 p, q, r;
  explicit Bilinear(const Corners& x)
      : p((x[1] + x[2] - x[0] - x[3]) / 4), q((x[2] + x[3] - x[0] - x[1]) / 4), r((x[0] + x[2] - x[1] - x[3]) / 4) {}
};

/// A_a [m^2] of a face with the corners at x [m].
inline Corners of(const Corners& x, int corners) {
  Corners areas;
  if (corners == 3) {
    areas[0] = areas[1] = areas[2] = (x[1] - x[0]).cross(x[2] - x[0]) / 6;
    areas[3].setZero();
    return areas;
  }
  const Bilinear patch(x);
  const Vec3 pq = patch.p.cross(patch.q), pr = patch.p.cross(patch.r) / 3, rq = patch.r.cross(patch.q) / 3;
  for (std::size_t a = 0; a < 4; ++a) areas[a] = pq + corner_s[a] * pr + corner_t[a] * rq;
  return areas;
}

/// w_ab [m] of dA_a = sum_b w_ab x dx_b; zero where a triangle has no corner.
inline Gradients gradients(const Corners& x, int corners) {
  Gradients w;
  if (corners == 3) {
    w.fill(Vec3::Zero());
    for (std::size_t b = 0; b < 3; ++b) w[b] = w[4 + b] = w[8 + b] = (x[(b + 2) % 3] - x[(b + 1) % 3]) / 6;
    return w;
  }
  const Bilinear patch(x);
  for (std::size_t b = 0; b < 4; ++b) {
    const double s = corner_s[b] / 4, t = corner_t[b] / 4, st = corner_s[b] * corner_t[b] / 4;
    const Vec3 pq = t * patch.p - s * patch.q, pr = (st * patch.p - s * patch.r) / 3,
               rq = (t * patch.r - st * patch.q) / 3;
    for (std::size_t a = 0; a < 4; ++a) w[4 * a + b] = pq + corner_s[a] * pr + corner_t[a] * rq;
  }
  return w;
}

}  // namespace area_vectors
}  // namespace stroma
