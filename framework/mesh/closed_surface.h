// SPDX-License-Identifier: LGPL-2.1-or-later
// The volume inside a closed surface (area_vectors.h): every edge is traversed equally often in both directions.
// Positions come from a function of the node (`position(node)` [m]), so that the surface can be stored in any
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

}  // namespace area_vectors
}  // namespace stroma
