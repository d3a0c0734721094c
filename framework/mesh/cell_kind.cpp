// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/mesh/cell_kind.h"

#include <algorithm>
#include <cmath>

#include "framework/mesh/simplex_size.h"

namespace stroma::cell_tables {

namespace {

/// dx/dxi, one column per axis of the cell.
Mat3 jacobian(const CellKind& kind, const LocalPoint& xi, const Vec3* x) {
  std::array<LocalPoint, most_cell_nodes> slopes;
  kind.gradients(xi, slopes.data());
  Mat3 columns = Mat3::Zero();
  for (int a = 0; a < kind.nodes; ++a)
    for (int i = 0; i < kind.dimension; ++i) columns.col(i) += slopes[a][i] * x[a];
  return columns;
}

}  // namespace

double edgeLength(const Vec3* x) { return simplexSize(1, x); }
double triangleArea(const Vec3* x) { return simplexSize(2, x); }
double tetrahedronSize(const Vec3* x) { return simplexSize(3, x); }

double quadArea(const Vec3* x) {
  double area = 0;
  for (const QuadraturePoint& point : cell_kinds::quad.rule(3).points) {
    const Mat3 j = jacobian(cell_kinds::quad, point.xi, x);
    area += point.weight * j.col(0).cross(j.col(1)).norm();
  }
  return area;
}

double hexahedronSize(const Vec3* x) {
  // det J of the trilinear map is quadratic in each coordinate.
  double volume = 0;
  for (const QuadraturePoint& point : cell_kinds::hexahedron.rule(2).points) {
    const Mat3 j = jacobian(cell_kinds::hexahedron, point.xi, x);
    volume += point.weight * j.col(0).cross(j.col(1)).dot(j.col(2));
  }
  return volume;
}

double tetrahedronShape(const Vec3* x) {
  const double volume = tetrahedronSize(x);
  double squares = 0;
  for (const auto& [a, b] : cell_kinds::tetrahedron.edges) squares += (x[b] - x[a]).squaredNorm();
  if (!(squares > 0)) return 0;
  return std::copysign(12 * std::cbrt(9 * volume * volume) / squares, volume);
}

double hexahedronShape(const Vec3* x) {
  // The corner tetrahedron of a cube of edge 1 has volume 1/6 and edges 1, 1, 1, sqrt 2, sqrt 2, sqrt 2.
  const double cube = 12 * std::cbrt(0.25) / 9;
  double worst = std::numeric_limits<double>::infinity();
  for (std::size_t a = 0; a < hexahedron_corner_edges.size(); ++a) {
    const auto& [i, j, k] = hexahedron_corner_edges[a];
    const Vec3 corner[] = {x[a], x[i], x[j], x[k]};
    worst = std::min(worst, tetrahedronShape(corner) / cube);
  }
  return worst;
}

}  // namespace stroma::cell_tables
