// SPDX-License-Identifier: LGPL-2.1-or-later
// The numbers behind the table of kinds of cells (cell_kind.h): reference nodes, edges, faces, shape functions and
// quadrature.
#pragma once
#include <algorithm>
#include <limits>
#include <span>

#include "framework/scene/types.h"

namespace stroma {

enum class CellType : int {
  point,
  edge,
  triangle,
  quad,
  tetrahedron,
  hexahedron,
  quadratic_triangle,
  quadratic_tetrahedron
};

inline constexpr int cell_types = 8;
inline constexpr int most_cell_nodes = 10;

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
  std::array<int, 6> nodes;  ///< repeats the last where there are fewer
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
/// Node k + corners of a quadratic cell lies between these corners.
inline constexpr std::array<std::array<int, 2>, 3> triangle_middles = triangle_edges;
inline constexpr std::array<std::array<int, 2>, 6> tetrahedron_middles{
    {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};
/// Half edges, from corner to middle.
template <std::size_t E>
constexpr auto halfEdges(const std::array<std::array<int, 2>, E>& middles, int corners) {
  std::array<std::array<int, 2>, 2 * E> halves{};
  for (std::size_t e = 0; e < E; ++e)
    halves[2 * e] = {middles[e][0], corners + int(e)}, halves[2 * e + 1] = {corners + int(e), middles[e][1]};
  return halves;
}
inline constexpr auto quadratic_triangle_edges = halfEdges(triangle_middles, 3);
inline constexpr auto quadratic_tetrahedron_edges = halfEdges(tetrahedron_middles, 4);
inline constexpr std::array<std::array<int, 2>, 12> hexahedron_edges{
    {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6}, {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}}};

/// Face i is opposite node i.
inline constexpr std::array<LocalFace, 4> tetrahedron_faces{{{CellType::triangle, {1, 2, 3, 3, 3, 3}},
                                                             {CellType::triangle, {0, 3, 2, 2, 2, 2}},
                                                             {CellType::triangle, {0, 1, 3, 3, 3, 3}},
                                                             {CellType::triangle, {0, 2, 1, 1, 1, 1}}}};
inline constexpr std::array<LocalFace, 4> quadratic_tetrahedron_faces{
    {{CellType::quadratic_triangle, {1, 2, 3, 5, 9, 8}},
     {CellType::quadratic_triangle, {0, 3, 2, 7, 9, 6}},
     {CellType::quadratic_triangle, {0, 1, 3, 4, 8, 7}},
     {CellType::quadratic_triangle, {0, 2, 1, 6, 5, 4}}}};
/// In the order -zeta, +zeta, -eta, +xi, +eta, -xi.
inline constexpr std::array<LocalFace, 6> hexahedron_faces{{{CellType::quad, {0, 3, 2, 1, 1, 1}},
                                                            {CellType::quad, {4, 5, 6, 7, 7, 7}},
                                                            {CellType::quad, {0, 1, 5, 4, 4, 4}},
                                                            {CellType::quad, {1, 2, 6, 5, 5, 5}},
                                                            {CellType::quad, {2, 3, 7, 6, 6, 6}},
                                                            {CellType::quad, {3, 0, 4, 7, 7, 7}}}};

inline constexpr std::array<std::array<int, 3>, 4> tetrahedron_corner_edges{
    {{1, 2, 3}, {2, 0, 3}, {0, 1, 3}, {0, 2, 1}}};
inline constexpr std::array<std::array<int, 3>, 4> quadratic_tetrahedron_corner_edges{
    {{4, 6, 7}, {5, 4, 8}, {6, 5, 9}, {7, 9, 8}}};
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

/// l_a (2 l_a - 1) at the corners and 4 l_a l_b between them, l the volume coordinates.
template <const auto& middles, int dimension>
constexpr void quadraticShapes(const LocalPoint& xi, double* n) {
  double l[dimension + 1]{};
  simplexShapes<dimension>(xi, l);
  for (std::size_t a = 0; a <= dimension; ++a) n[a] = l[a] * (2 * l[a] - 1);
  for (std::size_t e = 0; e < middles.size(); ++e) n[dimension + 1 + e] = 4 * l[middles[e][0]] * l[middles[e][1]];
}
template <const auto& middles, int dimension>
constexpr void quadraticGradients(const LocalPoint& xi, LocalPoint* slopes) {
  double l[dimension + 1]{};
  LocalPoint dl[dimension + 1]{};
  simplexShapes<dimension>(xi, l), simplexGradients<dimension>(xi, dl);
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t a = 0; a <= dimension; ++a) slopes[a][i] = (4 * l[a] - 1) * dl[a][i];
    for (std::size_t e = 0; e < middles.size(); ++e) {
      const auto [a, b] = middles[e];
      slopes[dimension + 1 + e][i] = 4 * (l[a] * dl[b][i] + dl[a][i] * l[b]);
    }
  }
}
/// The nodes of a quadratic simplex.
template <std::size_t N, std::size_t E>
constexpr std::array<LocalPoint, N + E> withMiddles(const std::array<LocalPoint, N>& corners,
                                                    const std::array<std::array<int, 2>, E>& middles) {
  std::array<LocalPoint, N + E> nodes{};
  for (std::size_t a = 0; a < N; ++a) nodes[a] = corners[a];
  for (std::size_t e = 0; e < E; ++e)
    for (std::size_t i = 0; i < 3; ++i) nodes[N + e][i] = (corners[middles[e][0]][i] + corners[middles[e][1]][i]) / 2;
  return nodes;
}
inline constexpr auto quadratic_triangle_nodes = withMiddles(triangle_nodes, triangle_middles);
inline constexpr auto quadratic_tetrahedron_nodes = withMiddles(tetrahedron_nodes, tetrahedron_middles);

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
/// The points (a, a, 1 - 2a) of a triangle, its weights w; (a, a, a, 1 - 3a) and (a, a, 1/2 - a, 1/2 - a) of a
/// tetrahedron. Sources: Strang and Fix 1973 (six points), Walkington 2000 (fourteen).
constexpr auto trianglePoints(double a, double w, double b, double v) {
  return std::array<QuadraturePoint, 6>{{{{a, a, 0}, w},
                                         {{1 - 2 * a, a, 0}, w},
                                         {{a, 1 - 2 * a, 0}, w},
                                         {{b, b, 0}, v},
                                         {{1 - 2 * b, b, 0}, v},
                                         {{b, 1 - 2 * b, 0}, v}}};
}
inline constexpr auto triangle_6 =
    trianglePoints(0.44594849091596488632, 0.11169079483900573285, 0.09157621350977074346, 0.05497587182766093382);
constexpr std::array<QuadraturePoint, 14> tetrahedronPoints() {
  constexpr double a[2] = {0.31088591926330060980, 0.092735250310891226402},
                   w[2] = {0.018781320953002641800, 0.012248840519393658257}, c = 0.045503704125649649492, d = 0.5 - c,
                   v = 0.0070910034628469110730;
  std::array<QuadraturePoint, 14> points{};
  for (std::size_t k = 0; k < 8; ++k) {
    points[k] = {{a[k / 4], a[k / 4], a[k / 4]}, w[k / 4]};
    if (k % 4 > 0) points[k].xi[k % 4 - 1] = 1 - 3 * a[k / 4];
  }
  for (std::size_t k = 0; k < 3; ++k) {  // c twice and d once leaves d for the fourth, c once and d twice c
    points[8 + k] = {{d, d, d}, v}, points[11 + k] = {{c, c, c}, v};
    points[8 + k].xi[k] = c, points[11 + k].xi[k] = d;
  }
  return points;
}
inline constexpr auto tetrahedron_14 = tetrahedronPoints();
inline constexpr std::array<QuadratureRule, 1> point_rules{{{std::numeric_limits<int>::max(), point_1}}};
inline constexpr std::array<QuadratureRule, 2> edge_rules{{{1, edge_1}, {3, edge_2}}},
    triangle_rules{{{1, triangle_1}, {2, triangle_3}}}, quad_rules{{{1, quad_1}, {3, quad_4}}},
    tetrahedron_rules{{{1, tetrahedron_1}, {2, tetrahedron_4}}},
    hexahedron_rules{{{1, hexahedron_1}, {3, hexahedron_8}}},
    quadratic_triangle_rules{{{2, triangle_3}, {4, triangle_6}}},
    quadratic_tetrahedron_rules{{{2, tetrahedron_4}, {5, tetrahedron_14}}};

/// Cells are numbered alike everywhere, but for the last edges of Gmsh's quadratic tetrahedron.
inline constexpr std::array<int, most_cell_nodes> same_order{0, 1, 2, 3, 4, 5, 6, 7, 8, 9},
    last_two_swapped{0, 1, 2, 3, 4, 5, 6, 7, 9, 8};
constexpr CellFormat format(int number, std::size_t nodes, const std::array<int, most_cell_nodes>& order = same_order) {
  return {number, {order.data(), nodes}};
}

double edgeLength(const Vec3* x);
double triangleArea(const Vec3* x);
double quadArea(const Vec3* x);
double tetrahedronSize(const Vec3* x);
double hexahedronSize(const Vec3* x);
double quadraticTriangleArea(const Vec3* x);
double quadraticTetrahedronSize(const Vec3* x);
double tetrahedronShape(const Vec3* x);
double hexahedronShape(const Vec3* x);
double quadraticTetrahedronShape(const Vec3* x);

}  // namespace cell_tables

}  // namespace stroma
