// SPDX-License-Identifier: LGPL-2.1-or-later
// The numbers behind the table of kinds of cells (cell_kind.h): reference nodes, edges, faces and shape functions.
#pragma once
#include <algorithm>
#include <span>

#include "framework/scene/types.h"

namespace stroma {

enum class CellType : int {
  point, edge, triangle, quad, tetrahedron, hexahedron, quadratic_triangle, quadratic_tetrahedron, prism, pyramid
};

inline constexpr int cell_types = 10;
inline constexpr int most_cell_nodes = 10;

/// xi, or a derivative along it; zero beyond the dimension of the cell.
using LocalPoint = std::array<double, 3>;

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
inline constexpr std::array<LocalPoint, 6> prism_nodes{{{0, 0, -1}, {1, 0, -1}, {0, 1, -1}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}}};
inline constexpr std::array<LocalPoint, 5> pyramid_nodes{{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}, {0, 0, 1}}};

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
inline constexpr std::array<std::array<int, 2>, 9> prism_edges{
    {{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}, {0, 3}, {1, 4}, {2, 5}}};
inline constexpr std::array<std::array<int, 2>, 8> pyramid_edges{{{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 4}, {1, 4}, {2, 4}, {3, 4}}};

constexpr LocalFace triangleFace(int a, int b, int c) { return {CellType::triangle, {a, b, c, c, c, c}}; }
constexpr LocalFace quadFace(int a, int b, int c, int d) { return {CellType::quad, {a, b, c, d, d, d}}; }
/// Face i is opposite node i.
inline constexpr std::array<LocalFace, 4> tetrahedron_faces{triangleFace(1, 2, 3), triangleFace(0, 3, 2), triangleFace(0, 1, 3),
                                                            triangleFace(0, 2, 1)};
inline constexpr std::array<LocalFace, 4> quadratic_tetrahedron_faces{{{CellType::quadratic_triangle, {1, 2, 3, 5, 9, 8}},
                                                                       {CellType::quadratic_triangle, {0, 3, 2, 7, 9, 6}},
                                                                       {CellType::quadratic_triangle, {0, 1, 3, 4, 8, 7}},
                                                                       {CellType::quadratic_triangle, {0, 2, 1, 6, 5, 4}}}};
/// In the order -zeta, +zeta, -eta, +xi, +eta, -xi.
inline constexpr std::array<LocalFace, 6> hexahedron_faces{quadFace(0, 3, 2, 1), quadFace(4, 5, 6, 7), quadFace(0, 1, 5, 4),
                                                           quadFace(1, 2, 6, 5), quadFace(2, 3, 7, 6), quadFace(3, 0, 4, 7)};
inline constexpr std::array<LocalFace, 5> prism_faces{triangleFace(0, 2, 1), triangleFace(3, 4, 5), quadFace(0, 1, 4, 3),
                                                      quadFace(1, 2, 5, 4), quadFace(2, 0, 3, 5)};
inline constexpr std::array<LocalFace, 5> pyramid_faces{quadFace(0, 3, 2, 1), triangleFace(0, 1, 4), triangleFace(1, 2, 4),
                                                        triangleFace(2, 3, 4), triangleFace(3, 0, 4)};

inline constexpr std::array<std::array<int, 3>, 4> tetrahedron_corner_edges{{{1, 2, 3}, {2, 0, 3}, {0, 1, 3}, {0, 2, 1}}},
    quadratic_tetrahedron_corner_edges{{{4, 6, 7}, {5, 4, 8}, {6, 5, 9}, {7, 9, 8}}};
inline constexpr std::array<std::array<int, 3>, 8> hexahedron_corner_edges{
    {{1, 3, 4}, {2, 0, 5}, {3, 1, 6}, {0, 2, 7}, {7, 5, 0}, {4, 6, 1}, {5, 7, 2}, {6, 4, 3}}};
inline constexpr std::array<std::array<int, 3>, 6> prism_corner_edges{
    {{1, 2, 3}, {2, 0, 4}, {0, 1, 5}, {5, 4, 0}, {3, 5, 1}, {4, 3, 2}}};
/// Of the four edges at the top three.
inline constexpr std::array<std::array<int, 3>, 5> pyramid_corner_edges{{{1, 3, 4}, {2, 0, 4}, {3, 1, 4}, {0, 2, 4}, {1, 0, 2}}};

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
/// Products of the triangle's l_a and those of an edge.
constexpr void prismShapes(const LocalPoint& xi, double* n) {
  simplexShapes<2>(xi, n);
  for (int a = 0; a < 3; ++a) n[a + 3] = 0.5 * (1 + xi[2]) * n[a], n[a] *= 0.5 * (1 - xi[2]);
}
constexpr void prismGradients(const LocalPoint& xi, LocalPoint* slopes) {
  double l[3]{};
  simplexShapes<2>(xi, l), simplexGradients<2>(xi, slopes);
  for (int a = 0; a < 3; ++a) {
    const auto [x, y, none] = slopes[a];
    const double low = 0.5 * (1 - xi[2]), high = 0.5 * (1 + xi[2]);
    slopes[a] = {low * x, low * y, -0.5 * l[a]}, slopes[a + 3] = {high * x, high * y, 0.5 * l[a]};
  }
}
/// Where the ray from the top through xi meets the base: u, v, with 0, 0 of the top itself.
constexpr std::array<double, 2> onBase(const LocalPoint& xi) {
  const double below = 1 - xi[2];
  return below == 0 ? std::array{0., 0.} : std::array{xi[0] / below, xi[1] / below};
}
constexpr void pyramidShapes(const LocalPoint& xi, double* n) {
  const auto [u, v] = onBase(xi);
  for (std::size_t a = 0; a < 4; ++a) n[a] = 0.25 * (1 - xi[2]) * (1 + pyramid_nodes[a][0] * u) * (1 + pyramid_nodes[a][1] * v);
  n[4] = xi[2];
}
/// They are the same all along a ray.
constexpr void pyramidGradients(const LocalPoint& xi, LocalPoint* slopes) {
  const auto [u, v] = onBase(xi);
  for (std::size_t a = 0; a < 4; ++a) {
    const auto [s, t, none] = pyramid_nodes[a];
    slopes[a] = {0.25 * s * (1 + t * v), 0.25 * t * (1 + s * u), 0.25 * (s * t * u * v - 1)};
  }
  slopes[4] = {0, 0, 1};
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

constexpr void holdInPrism(LocalPoint& xi) {
  holdInSimplex<2>(xi);
  xi[2] = std::min(std::max(xi[2], -1.), 1.);
}
constexpr void holdInPyramid(LocalPoint& xi) {
  xi[2] = std::min(std::max(xi[2], 0.), 1.);
  for (std::size_t i = 0; i < 2; ++i) xi[i] = std::min(std::max(xi[i], xi[2] - 1), 1 - xi[2]);
}

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
double prismSize(const Vec3* x);
double pyramidSize(const Vec3* x);
double quadraticTriangleArea(const Vec3* x);
double quadraticTetrahedronSize(const Vec3* x);

}  // namespace cell_tables

}  // namespace stroma
