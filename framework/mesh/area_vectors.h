// SPDX-License-Identifier: LGPL-2.1-or-later
// What a surface of triangles, bilinear quads and quadratic triangles sums its areas and volumes from. The area vector of
// node a of a face
//   A_a = integral of N_a n dA
// is what a pressure of 1 does there. For a triangle A_a = (x_1 - x_0) x (x_2 - x_0) / 6. For a quad, with the
// parameters -1 <= s, t <= 1 and corners at (s_a, t_a) = (-1,-1), (1,-1), (1,1), (-1,1),
//   x = m + s p + t q + s t r,   A_a = p x q + s_a/3 p x r + t_a/3 r x q
// also where the quad is warped. Of a quadratic triangle, with x_s = sum_b dN_b/ds x_b,
//   A_a = sum_q w_q N_a x_s x x_t,   w_ab = sum_q w_q N_a (dN_b/dt x_s - dN_b/ds x_t)
// over the points q of a rule of degree 4, which is exact. The volume behind a closed surface is V = 1/3 sum x_a . A_a,
// and dV/dx_a = sum A_a over the faces at the node.
#pragma once
#include <Eigen/Geometry>
#include <array>

#include "framework/mesh/cell_kind.h"

namespace stroma {

inline constexpr std::size_t most_face_nodes = 6;

/// A triangle, a quad or a quadratic triangle; faces with fewer nodes repeat the last one.
struct Face {
  std::array<Index, most_face_nodes> nodes;
  int corners;  ///< how many nodes it has
  Face(const Triangle& t) : nodes{t[0], t[1], t[2], t[2], t[2], t[2]}, corners(3) {}
  Face(const Quad& q) : nodes{q[0], q[1], q[2], q[3], q[3], q[3]}, corners(4) {}
  Face(const QuadraticTriangle& t) : nodes(t), corners(6) {}
  const CellKind& kind() const {
    return corners == 3 ? cell_kinds::triangle : corners == 4 ? cell_kinds::quad : cell_kinds::quadratic_triangle;
  }
};

namespace area_vectors {

using Corners = std::array<Vec3, most_face_nodes>;  ///< positions or area vectors, as many as the face has nodes
using Gradients = std::array<Vec3, most_face_nodes * most_face_nodes>;  ///< w_ab at most_face_nodes a + b

constexpr double corner_s[4] = {-1, 1, 1, -1}, corner_t[4] = {-1, -1, 1, 1};

/// p, q, r of a quad.
struct Bilinear {
  Vec3 p, q, r;
  explicit Bilinear(const Corners& x)
      : p((x[1] + x[2] - x[0] - x[3]) / 4), q((x[2] + x[3] - x[0] - x[1]) / 4), r((x[0] + x[2] - x[1] - x[3]) / 4) {}
};

/// visit(w N, dN, x_s, x_t) at the points of a quadratic triangle.
template <class Visit>
void forEachQuadraticPoint(const Corners& x, Visit&& visit) {
  for (const QuadraturePoint& point : cell_kinds::quadratic_triangle.rule(4).points) {
    std::array<double, most_face_nodes> n;
    std::array<LocalPoint, most_face_nodes> slopes;
    cell_kinds::quadratic_triangle.shapes(point.xi, n.data());
    cell_kinds::quadratic_triangle.gradients(point.xi, slopes.data());
    Vec3 s = Vec3::Zero(), t = Vec3::Zero();
    for (std::size_t b = 0; b < x.size(); ++b) n[b] *= point.weight, s += slopes[b][0] * x[b], t += slopes[b][1] * x[b];
    visit(n, slopes, s, t);
  }
}

/// A_a [m^2] of a face with the corners at x [m]; zero where it has no node.
inline Corners of(const Corners& x, int corners) {
  Corners areas;
  areas.fill(Vec3::Zero());
  if (corners == 3) {
    areas[0] = areas[1] = areas[2] = (x[1] - x[0]).cross(x[2] - x[0]) / 6;
    return areas;
  }
  if (corners == 6) {
    forEachQuadraticPoint(x, [&](const auto& n, const auto&, const Vec3& s, const Vec3& t) {
      for (std::size_t a = 0; a < areas.size(); ++a) areas[a] += n[a] * s.cross(t);
    });
    return areas;
  }
  const Bilinear patch(x);
  const Vec3 pq = patch.p.cross(patch.q), pr = patch.p.cross(patch.r) / 3, rq = patch.r.cross(patch.q) / 3;
  for (std::size_t a = 0; a < 4; ++a) areas[a] = pq + corner_s[a] * pr + corner_t[a] * rq;
  return areas;
}

/// w_ab [m] of dA_a = sum_b w_ab x dx_b; zero where a triangle has no corner.
inline Gradients gradients(const Corners& x, int corners) {
  constexpr std::size_t n = most_face_nodes;
  Gradients w;
  w.fill(Vec3::Zero());
  if (corners == 3) {
    for (std::size_t b = 0; b < 3; ++b) w[b] = w[n + b] = w[2 * n + b] = (x[(b + 2) % 3] - x[(b + 1) % 3]) / 6;
    return w;
  }
  if (corners == 6) {
    forEachQuadraticPoint(x, [&](const auto& shape, const auto& slopes, const Vec3& s, const Vec3& t) {
      for (std::size_t a = 0; a < n; ++a)
        for (std::size_t b = 0; b < n; ++b) w[n * a + b] += shape[a] * (slopes[b][1] * s - slopes[b][0] * t);
    });
    return w;
  }
  const Bilinear patch(x);
  for (std::size_t b = 0; b < 4; ++b) {
    const double s = corner_s[b] / 4, t = corner_t[b] / 4, st = corner_s[b] * corner_t[b] / 4;
    const Vec3 pq = t * patch.p - s * patch.q, pr = (st * patch.p - s * patch.r) / 3,
               rq = (t * patch.r - st * patch.q) / 3;
    for (std::size_t a = 0; a < 4; ++a) w[n * a + b] = pq + corner_s[a] * pr + corner_t[a] * rq;
  }
  return w;
}

}  // namespace area_vectors
}  // namespace stroma
