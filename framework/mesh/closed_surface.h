// SPDX-License-Identifier: LGPL-2.1-or-later
// The volume behind a surface of faces (area_vectors.h) that is closed: every edge is run through as often one
// way as the other. Positions come from a function of the node (`position(node)` [m]), so that a surface can lie in any
// vector.
#pragma once
#include <optional>
#include <vector>

#include "framework/mesh/area_vectors.h"

namespace stroma {

/// An edge at which a surface is not closed, and how many faces run through it from nodes[0] to nodes[1] and back.
struct OpenEdge {
  Edge nodes{};
  int along = 0, back = 0;
};

/// The first open edge by its nodes, ascending; none when the surface is closed.
std::optional<OpenEdge> firstOpenEdge(const std::vector<Face>& faces);

namespace area_vectors {

/// The corners of a face, less `origin`: far from the origin of space the terms of a volume would cancel.
template <class Position>
Corners cornersOf(const Face& face, const Position& position, const Vec3& origin = Vec3::Zero()) {
  Corners x;
  for (std::size_t a = 0; a < x.size(); ++a) x[a] = position(face.nodes[a]) - origin;
  return x;
}

/// V = 1/3 sum x_a . A_a [m^3].
template <class Position>
double volumeBehind(const std::vector<Face>& faces, const Position& position) {
  const Vec3& origin = position(faces[0].nodes[0]);
  double sum = 0;
  for (const Face& face : faces) {
    const Corners x = cornersOf(face, position, origin), areas = of(x, face.corners);
    for (std::size_t a = 0; a < std::size_t(face.corners); ++a) sum += x[a].dot(areas[a]) / 3;
  }
  return sum;
}

/// The coefficients of V(x + s d), a cubic in s. V is a symmetric form in three positions, so that with areas A(x) and
/// A(d) of the surface at x and of the one that has d for its positions
///   V(x + s d) = 1/3 sum x.A(x) + s sum d.A(x) + s^2 sum x.A(d) + s^3 1/3 sum d.A(d).
template <class Position, class Direction>
std::array<double, 4> volumeAlong(const std::vector<Face>& faces, const Position& position,
                                  const Direction& direction) {
  const Vec3 origin = position(faces[0].nodes[0]);
  std::array<double, 4> sums{};
  for (const Face& face : faces) {
    const Corners x = cornersOf(face, position, origin), d = cornersOf(face, direction);
    const Corners areas_x = of(x, face.corners), areas_d = of(d, face.corners);
    for (std::size_t a = 0; a < std::size_t(face.corners); ++a) {
      sums[0] += x[a].dot(areas_x[a]) / 3;
      sums[1] += d[a].dot(areas_x[a]);
      sums[2] += x[a].dot(areas_d[a]);
      sums[3] += d[a].dot(areas_d[a]) / 3;
    }
  }
  return sums;
}

}  // namespace area_vectors
}  // namespace stroma
