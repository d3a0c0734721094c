// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/mesh_report/cell_quality.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stroma {
namespace {

double meanRatio(const Vec3* x) {
  const double volume = cell_kinds::tetrahedron.size(x);
  double squares = 0;
  for (const auto& [a, b] : cell_kinds::tetrahedron.edges) squares += (x[b] - x[a]).squaredNorm();
  if (!(squares > 0)) return 0;
  return std::copysign(12 * std::cbrt(9 * volume * volume) / squares, volume);
}

double determinantAt(const CellKind& kind, const LocalPoint& xi, const Vec3* x) {
  std::array<LocalPoint, most_cell_nodes> slopes;
  kind.gradients(xi, slopes.data());
  Mat3 j = Mat3::Zero();
  for (int a = 0; a < kind.nodes; ++a) j += x[a] * Vec3(slopes[a].data()).transpose();
  return j.determinant();
}

double ofQuadratic(const Vec3* x) {
  const double corners = meanRatio(x), flat = 6 * cell_kinds::tetrahedron.size(x);
  double least = 1;  // 1 where middles are in the middle
  for (const LocalPoint& xi : cell_kinds::quadratic_tetrahedron.reference)
    least = std::min(least, determinantAt(cell_kinds::quadratic_tetrahedron, xi, x) / flat);
  return corners > 0 ? corners * least : corners;
}

/// The mean ratio of the tetrahedra at the corners of the best cell.
double bestCorner(const CellKind& kind) {
  switch (kind.type) {
    case CellType::prism:
      return 1.6 * std::cbrt(5. / 32);  // the height is (5/6)^(1/2) edges of an equilateral triangle
    case CellType::pyramid:
      return 16. / 11 * std::cbrt(11. / 48);  // the height is (11/12)^(1/2) edges of a square
    default:
      return 12 * std::cbrt(0.25) / 9;  // a cube of edge 1: volume 1/6 and edges 1, 1, 1, sqrt 2, sqrt 2, sqrt 2
  }
}

}  // namespace

double cellQuality(const CellKind& kind, const Vec3* x) {
  if (kind.type == CellType::tetrahedron) return meanRatio(x);
  if (kind.type == CellType::quadratic_tetrahedron) return ofQuadratic(x);
  double worst = std::numeric_limits<double>::infinity();
  for (std::size_t a = 0; a < kind.corner_edges.size(); ++a) {
    const auto& [i, j, k] = kind.corner_edges[a];
    const Vec3 corner[] = {x[a], x[i], x[j], x[k]};
    worst = std::min(worst, meanRatio(corner) / bestCorner(kind));
  }
  return worst;
}

}  // namespace stroma
