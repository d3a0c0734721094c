// SPDX-License-Identifier: LGPL-2.1-or-later
// The numbers behind the table of kinds of cells (cell_kind.h): reference nodes, edges, faces, shape functions and
// quadrature.
#pragma once
#include <algorithm>
#include <limits>
#include <span>

#include "framework/scene/types.h"

namespace stroma {

enum class CellType : int { point, edge, triangle, quad, tetrahedron, hexahedron };

inline constexpr int cell_types = 6;
inline constexpr int most_cell_nodes = 8;

/// xi, or a derivative along it; zero beyond the dimension of the cell.
using LocalPoint = std::array<double, 3>;

struct QuadraturePoint {
  LocalPoint xi;
  double weight;
};

/// Weights sum to the size of the reference cell. Point a of a rule with as many points as a box has nodes lies towards
/// node a.
struct QuadratureRule {
  int degree;  ///< exact for polynomials of this degree: in all for simplices, along each axis for boxes
  std::span<const QuadraturePoint> points;
};

/// A face of a volume cell, counter-clockwise seen from outside a cell of positive volume.
struct LocalFace {
  CellType type;
  std::array<int, 4> nodes;  ///< a triangle repeats its last node
};

/// How a file format numbers a kind of cell.
struct CellFormat {
  int number;
  std::span<const int> order;  ///< node k of the format is our node order[k]
};

namespace cell_tables {

inline constexpr std::array<LocalPoint, 1> point_nodes{{{0, 0, 0}}};
inline constexpr std::array<LocalPoint, 2> edge_nodes{{{-1, 0, 0}, {1, 0, 0}}};
inline constexpr std::array<LocalPoint, 3> triangle_nodes{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
inline constexpr std::array<LocalPoint, 4> quad_nodes{{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}};
inline constexpr std::array<LocalPoint, 4> tetrahedron_nodes{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
inline constexpr std::array<LocalPoint, 8> hexahedron_nodes{
    {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {1, 1, 1}, {-1, 1, 1}}};

inline constexpr std::array<std::array<int, 2>, 1> edge_edges{{{0, 1}}};
inline constexpr std::array<std::array<int, 2>, 3> triangle_edges{{{0, 1}, {1, 2}, {2, 0}}};
inline constexpr std::array<std::array<int, 2>, 4> quad_edges{{{0, 1}, {1, 2}, {2, 3}, {3, 0}}};
inline constexpr std::array<std::array<int, 2>, 6> tetrahedron_edges{{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};
inline constexpr std::array<std::array<int, 2>, 12> hexahedron_edges{
    {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6}, {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}}};

/// Face i is opposite node i.
inline constexpr std::array<LocalFace, 4> tetrahedron_faces{{{CellType::triangle, {1, 2, 3, 3}},
                                                             {CellType::triangle, {0, 3, 2, 2}},
                                                             {CellType::triangle, {0, 1, 3, 3}},
                                                             {CellType::triangle, {0, 2, 1, 1}}}};
/// In the order -zeta, +zeta, -eta, +xi, +eta, -xi.
inline constexpr std::array<LocalFace, 6> hexahedron_faces{{{CellType::quad, {0, 3, 2, 1}},
                                                            {CellType::quad, {4, 5, 6, 7}},
                                                            {CellType::quad, {0, 1, 5, 4}},
                                                            {CellType::quad, {1, 2, 6, 5}},
                                                            {CellType::quad, {2, 3, 7, 6}},
                                                            {CellType::quad, {3, 0, 4, 7}}}};

inline constexpr std::array<std::array<int, 3>, 4> tetrahedron_corner_edges{
    {{1, 2, 3}, {2, 0, 3}, {0, 1, 3}, {0, 2, 1}}};
inline constexpr std::array<std::array<int, 3>, 8> hexahedron_corner_edges{
    {{1, 3, 4}, {2, 0, 5}, {3, 1, 6}, {0, 2, 7}, {7, 5, 0}, {4, 6, 1}, {5, 7, 2}, {6, 4, 3}}};

template <const auto& nodes, int dimension>
constexpr void boxShapes(const LocalPoint& xi, double* n) {
  for (std::size_t a = 0; a < nodes.size(); ++a) {
    n[a] = 1;
    for (std::size_t i = 0; i < dimension; ++i) n[a] *= 0.5 * (1 + nodes[a][i] * xi[i]);
  }
}
template <const auto& nodes, int dimension>
constexpr void boxGradients(const LocalPoint& xi, LocalPoint* slopes) {
  for (std::size_t a = 0; a < nodes.size(); ++a)
    for (std::size_t i = 0; i < 3; ++i) {
      slopes[a][i] = i < dimension ? 1 : 0;
      for (std::size_t k = 0; k < dimension; ++k)
        slopes[a][i] *= k == i ? 0.5 * nodes[a][k] : 0.5 * (1 + nodes[a][k] * xi[k]);
    }
}
template <int dimension>
constexpr void simplexShapes(const LocalPoint& xi, double* n) {
  n[0] = 1;
  for (std::size_t i = 0; i < dimension; ++i) n[0] -= xi[i], n[i + 1] = xi[i];
}
template <int dimension>
constexpr void simplexGradients(const LocalPoint&, LocalPoint* slopes) {
  for (std::size_t a = 0; a <= dimension; ++a)
    for (std::size_t i = 0; i < 3; ++i) slopes[a][i] = i >= dimension ? 0 : a == 0 ? -1 : a == i + 1 ? 1 : 0;
}

template <int dimension>
constexpr void holdInBox(LocalPoint& xi) {
  for (std::size_t i = 0; i < dimension; ++i) xi[i] = std::min(std::max(xi[i], -1.), 1.);
}
/// Negative shares become zero, and the others sum to one again.
template <int dimension>
constexpr void holdInSimplex(LocalPoint& xi) {
  double first = 1, sum = 0;
  for (std::size_t i = 0; i < dimension; ++i) first -= xi[i], xi[i] = std::max(xi[i], 0.), sum += xi[i];
  sum += std::max(first, 0.);
  for (std::size_t i = 0; i < dimension; ++i) xi[i] /= sum;
}

/// Gauss's two points of [-1, 1] along each axis, at s_a / sqrt 3.
inline constexpr double gauss = 1 / 1.7320508075688772;
template <std::size_t N>
constexpr std::array<QuadraturePoint, N> gaussPoints(const std::array<LocalPoint, N>& nodes) {
  std::array<QuadraturePoint, N> points{};
  for (std::size_t a = 0; a < N; ++a) points[a] = {{nodes[a][0] * gauss, nodes[a][1] * gauss, nodes[a][2] * gauss}, 1};
  return points;
}
inline constexpr std::array<QuadraturePoint, 1> point_1{{{{0, 0, 0}, 1}}}, edge_1{{{{0, 0, 0}, 2}}},
    triangle_1{{{{1. / 3, 1. / 3, 0}, 1. / 2}}}, quad_1{{{{0, 0, 0}, 4}}},
    tetrahedron_1{{{{1. / 4, 1. / 4, 1. / 4}, 1. / 6}}}, hexahedron_1{{{{0, 0, 0}, 8}}};
inline constexpr auto edge_2 = gaussPoints(edge_nodes);
inline constexpr auto quad_4 = gaussPoints(quad_nodes);
inline constexpr auto hexahedron_8 = gaussPoints(hexahedron_nodes);
inline constexpr std::array<QuadraturePoint, 3> triangle_3{
    {{{1. / 6, 1. / 6, 0}, 1. / 6}, {{2. / 3, 1. / 6, 0}, 1. / 6}, {{1. / 6, 2. / 3, 0}, 1. / 6}}};
/// (5 -+ sqrt 5) / 20 and what is left for the fourth. Source: Hammer and Stroud 1956.
inline constexpr double near_face = 0.1381966011250105, near_node = 0.5854101966249685;
inline constexpr std::array<QuadraturePoint, 4> tetrahedron_4{{{{near_face, near_face, near_face}, 1. / 24},
                                                               {{near_node, near_face, near_face}, 1. / 24},
                                                               {{near_face, near_node, near_face}, 1. / 24},
                                                               {{near_face, near_face, near_node}, 1. / 24}}};
inline constexpr std::array<QuadratureRule, 1> point_rules{{{std::numeric_limits<int>::max(), point_1}}};
inline constexpr std::array<QuadratureRule, 2> edge_rules{{{1, edge_1}, {3, edge_2}}},
    triangle_rules{{{1, triangle_1}, {2, triangle_3}}}, quad_rules{{{1, quad_1}, {3, quad_4}}},
    tetrahedron_rules{{{1, tetrahedron_1}, {2, tetrahedron_4}}},
    hexahedron_rules{{{1, hexahedron_1}, {3, hexahedron_8}}};

/// Linear cells are numbered alike everywhere.
inline constexpr std::array<int, most_cell_nodes> same_order{0, 1, 2, 3, 4, 5, 6, 7};
constexpr CellFormat format(int number, std::size_t nodes) { return {number, {same_order.data(), nodes}}; }

double edgeLength(const Vec3* x);
double triangleArea(const Vec3* x);
double quadArea(const Vec3* x);
double tetrahedronSize(const Vec3* x);
double hexahedronSize(const Vec3* x);
double tetrahedronShape(const Vec3* x);
double hexahedronShape(const Vec3* x);

}  // namespace cell_tables

}  // namespace stroma
