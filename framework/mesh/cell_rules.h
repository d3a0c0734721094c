// SPDX-License-Identifier: LGPL-2.1-or-later
// The quadrature behind the table of kinds of cells (cell_kind.h).
#pragma once
#include <limits>

#include "framework/mesh/cell_tables.h"

namespace stroma {

struct QuadraturePoint {
  LocalPoint xi;
  double weight;
};

/// Weights sum to the size of the reference cell. Point a of a rule with as many points as a box has nodes lies towards
/// node a.
struct QuadratureRule {
  int degree;  ///< exact for polynomials of this degree: in all, but along each axis for boxes
  std::span<const QuadraturePoint> points;
};

namespace cell_tables {

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
/// A rule of the triangle at Gauss's two heights.
template <std::size_t N>
constexpr auto prismPoints(const std::array<QuadraturePoint, N>& triangle) {
  std::array<QuadraturePoint, 2 * N> points{};
  for (std::size_t k = 0; k < N; ++k)
    for (std::size_t h = 0; h < 2; ++h)
      points[h * N + k] = {{triangle[k].xi[0], triangle[k].xi[1], h == 0 ? -gauss : gauss}, triangle[k].weight};
  return points;
}
/// The points of the base's rule on their rays, at the distances s from the top with the weights w of the weight s^2 of [0, 1].
template <std::size_t N>
constexpr auto pyramidPoints(const std::array<std::array<double, 2>, N>& heights) {
  std::array<QuadraturePoint, 4 * N> points{};
  for (std::size_t k = 0; k < 4 * N; ++k) {
    const auto [s, w] = heights[k / 4];
    points[k] = {{quad_4[k % 4].xi[0] * s, quad_4[k % 4].xi[1] * s, 1 - s}, w};
  }
  return points;
}
inline constexpr auto prism_2 = prismPoints(triangle_1);
inline constexpr auto prism_6 = prismPoints(triangle_3);
inline constexpr auto pyramid_4 = pyramidPoints<1>({{{3. / 4, 1. / 3}}});
/// 2/3 -+ (2/45)^(1/2) with 1/6 -+ (5/8)^(1/2)/12.
inline constexpr auto pyramid_8 =
    pyramidPoints<2>({{{0.45584815598877471, 0.10078588207982543}, {0.87748517734455862, 0.23254745125350790}}});
inline constexpr std::array<QuadratureRule, 1> point_rules{{{std::numeric_limits<int>::max(), point_1}}};
inline constexpr std::array<QuadratureRule, 2> edge_rules{{{1, edge_1}, {3, edge_2}}},
    triangle_rules{{{1, triangle_1}, {2, triangle_3}}}, quad_rules{{{1, quad_1}, {3, quad_4}}},
    tetrahedron_rules{{{1, tetrahedron_1}, {2, tetrahedron_4}}},
    hexahedron_rules{{{1, hexahedron_1}, {3, hexahedron_8}}}, prism_rules{{{1, prism_2}, {2, prism_6}}},
    pyramid_rules{{{1, pyramid_4}, {3, pyramid_8}}},
    quadratic_triangle_rules{{{2, triangle_3}, {4, triangle_6}}},
    quadratic_tetrahedron_rules{{{2, tetrahedron_4}, {5, tetrahedron_14}}};

}  // namespace cell_tables

}  // namespace stroma
