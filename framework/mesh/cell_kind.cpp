// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/mesh/cell_kind.h"

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

/// With the best rule: |J_1 x J_2| is no polynomial.
double integralOfArea(const CellKind& kind, const Vec3* x) {
  double area = 0;
  for (const QuadraturePoint& point : kind.rules.back().points) {
    const Mat3 j = jacobian(kind, point.xi, x);
    area += point.weight * j.col(0).cross(j.col(1)).norm();
  }
  return area;
}

double determinantAt(const CellKind& kind, const LocalPoint& xi, const Vec3* x) {
  const Mat3 j = jacobian(kind, xi, x);
  return j.col(0).cross(j.col(1)).dot(j.col(2));
}

double integralOfDeterminant(const CellKind& kind, int degree, const Vec3* x) {
  double volume = 0;
  for (const QuadraturePoint& point : kind.rule(degree).points) volume += point.weight * determinantAt(kind, point.xi, x);
  return volume;
}

}  // namespace

double edgeLength(const Vec3* x) { return simplexSize(1, x); }
double triangleArea(const Vec3* x) { return simplexSize(2, x); }
double tetrahedronSize(const Vec3* x) { return simplexSize(3, x); }
double quadArea(const Vec3* x) { return integralOfArea(cell_kinds::quad, x); }
double quadraticTriangleArea(const Vec3* x) { return integralOfArea(cell_kinds::quadratic_triangle, x); }

// det J is quadratic in each coordinate of a box, linear in xi and eta of a prism, on a pyramid's base quadratic and alike on rays.
double hexahedronSize(const Vec3* x) { return integralOfDeterminant(cell_kinds::hexahedron, 2, x); }
double prismSize(const Vec3* x) { return integralOfDeterminant(cell_kinds::prism, 1, x); }
double pyramidSize(const Vec3* x) { return integralOfDeterminant(cell_kinds::pyramid, 1, x); }
double quadraticTetrahedronSize(const Vec3* x) { return integralOfDeterminant(cell_kinds::quadratic_tetrahedron, 3, x); }

}  // namespace stroma::cell_tables
