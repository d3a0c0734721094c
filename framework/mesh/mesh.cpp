// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/mesh/mesh.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "framework/mesh/cell_faces.h"

namespace stroma {

namespace {

template <class Cell>
std::string firstCellError(const std::vector<Cell>& cells, std::string_view word, Index nodes) {
  for (std::size_t c = 0; c < cells.size(); ++c) {
    Cell sorted = cells[c];
    std::sort(sorted.begin(), sorted.end());
    if (sorted.front() < 0 || sorted.back() >= nodes)
      return fmt::format("{} {} names node {}, but the mesh has {} nodes (0 to {})", word, c,
                         sorted.front() < 0 ? sorted.front() : sorted.back(), nodes, nodes - 1);
    const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
    if (twice != sorted.end()) return fmt::format("{} {} names node {} twice", word, c, *twice);
  }
  return {};
}

}  // namespace

double tetrahedronVolume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return (b - a).cross(c - a).dot(d - a) / 6;
}

double hexahedronVolume(const std::array<Vec3, 8>& corner) {
  // det J of the trilinear map is quadratic in each coordinate: two Gauss points a direction integrate it exactly.
  const double g = 1 / std::sqrt(3.0);
  constexpr double sx[8] = {-1, 1, 1, -1, -1, 1, 1, -1}, sy[8] = {-1, -1, 1, 1, -1, -1, 1, 1},
                   sz[8] = {-1, -1, -1, -1, 1, 1, 1, 1};
  double volume = 0;
  for (int point = 0; point < 8; ++point) {
    const double x = g * sx[point], y = g * sy[point], z = g * sz[point];
    Vec3 dx = Vec3::Zero(), dy = Vec3::Zero(), dz = Vec3::Zero();
    for (std::size_t i = 0; i < 8; ++i) {
      dx += 0.125 * sx[i] * (1 + sy[i] * y) * (1 + sz[i] * z) * corner[i];
      dy += 0.125 * sy[i] * (1 + sx[i] * x) * (1 + sz[i] * z) * corner[i];
      dz += 0.125 * sz[i] * (1 + sx[i] * x) * (1 + sy[i] * y) * corner[i];
    }
    volume += dx.cross(dy).dot(dz);
  }
  return volume;
}

double tetrahedronQuality(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const double volume = tetrahedronVolume(a, b, c, d);
  const double squares = (b - a).squaredNorm() + (c - a).squaredNorm() + (d - a).squaredNorm() + (c - b).squaredNorm() +
                         (d - b).squaredNorm() + (d - c).squaredNorm();
  if (!(squares > 0)) return 0;
  return std::copysign(12 * std::cbrt(9 * volume * volume) / squares, volume);
}

double hexahedronQuality(const std::array<Vec3, 8>& corner) {
  // The corner tetrahedron of a cube of edge 1 has volume 1/6 and edges 1, 1, 1, sqrt 2, sqrt 2, sqrt 2.
  const double cube = 12 * std::cbrt(0.25) / 9;
  double worst = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 8; ++i) {
    const auto& [x, y, z] = hexahedron_corner_edges[i];
    const double quality = tetrahedronQuality(corner[i], corner[x], corner[y], corner[z]);
    worst = std::min(worst, quality / cube);
  }
  return worst;
}

std::string Mesh::firstError() const {
  if (position.size() > std::size_t(std::numeric_limits<Index>::max()))
    return fmt::format("{} nodes are more than a 32-bit index can name", position.size());
  for (std::size_t n = 0; n < position.size(); ++n)
    if (!position[n].allFinite())
      return fmt::format("the position of node {} is not finite: {} {} {}", n, position[n].x(), position[n].y(),
                         position[n].z());
  std::string error = firstCellError(edges, "edge", nodes());
  if (error.empty()) error = firstCellError(triangles, "triangle", nodes());
  if (error.empty()) error = firstCellError(quads, "quad", nodes());
  if (error.empty()) error = firstCellError(tetrahedra, "tetrahedron", nodes());
  if (error.empty()) error = firstCellError(hexahedra, "hexahedron", nodes());
  return error;
}

}  // namespace stroma
