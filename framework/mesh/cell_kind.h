// SPDX-License-Identifier: LGPL-2.1-or-later
// What a kind of cell is, in one table: names, numbering, shape functions, quadrature, and how files number it. Meshes,
// loaders, masses, mappings and exporters read it; a further kind is one more entry.
//
// x(xi) = sum_a N_a(xi) x_a maps the reference cell to the cell. Boxes (edge, quad, hexahedron) have -1 <= xi_i <= 1 and
//   N_a = prod_i (1 + s_ai xi_i) / 2,   s_a the coordinates of node a,
// simplices (triangle, tetrahedron) xi_i >= 0, sum xi_i <= 1 and N_0 = 1 - sum xi_i, N_i = xi_i. With l_a these N_a, the
// quadratic simplices have N_a = l_a (2 l_a - 1) at corners and 4 l_a l_b at the node between corners a and b. A prism has
// the products of a triangle's and an edge's. A pyramid has the base -1 <= xi, eta <= 1 and its top at zeta = 1; with s = 1 - zeta
//   N_a = s (1 + xi_a xi / s) (1 + eta_a eta / s) / 4 at the base,   N_4 = zeta,
// so that its faces have the functions of quads and triangles and fit to their neighbours.
#pragma once
#include <string_view>

#include "framework/mesh/cell_rules.h"

namespace stroma {

struct CellKind {
  CellType type{};
  std::string_view singular{}, plural{};  ///< "tetrahedron", "tetrahedra"
  std::string_view word{};                ///< in template="Vec3,Tetrahedron"
  std::string_view alias{};               ///< SOFA's second word for a list of these cells ("tetras"), or empty
  int nodes = 0, dimension = 0;
  int order = 1;                            ///< degree of the shape functions
  bool affine = false;                      ///< x(xi) is affine, whatever the nodes: a simplex
  std::span<const LocalPoint> reference{};  ///< xi of the nodes
  std::span<const std::array<int, 2>>
      edges{};  ///< by local nodes, halves in quadratic cells; of triangles and quads all the way round
  std::span<const LocalFace> faces{};  ///< of volume cells
  /// Of volume cells: the three nodes joined to a corner by an edge, right-handed. Their tetrahedron with the node has the
  /// sign of the cell there.
  std::span<const std::array<int, 3>> corner_edges{};
  std::span<const QuadratureRule> rules{};                                ///< ascending in degree
  void (*shapes)(const LocalPoint& xi, double* n) = nullptr;              ///< N_a, shape (nodes)
  void (*gradients)(const LocalPoint& xi, LocalPoint* slopes) = nullptr;  ///< dN_a/dxi, shape (nodes)
  void (*hold)(LocalPoint& xi) = nullptr;  ///< moves a point outside of the reference cell to its border
  /// Length [m], area [m^2] or signed volume [m^3] of the cell with nodes at x, shape (nodes); null for points.
  double (*size)(const Vec3* x) = nullptr;
  CellFormat vtk{}, gmsh{};

  /// The rule with the fewest points that is exact for this degree; the last when there is none.
  constexpr const QuadratureRule& rule(int degree) const {
    for (const QuadratureRule& candidate : rules)
      if (candidate.degree >= degree) return candidate;
    return rules.back();
  }
};

namespace cell_kinds {

using namespace cell_tables;  // NOLINT(google-build-using-namespace): one table in three files

/// What follows from the nodes of a reference cell.
template <const auto& corners, int dimension>
inline constexpr CellKind box{.nodes = int(corners.size()), .dimension = dimension, .affine = dimension == 1, .reference = corners,
                              .shapes = boxShapes<corners, dimension>, .gradients = boxGradients<corners, dimension>,
                              .hold = holdInBox<dimension>};
template <const auto& corners, int dimension>
inline constexpr CellKind simplex{.nodes = dimension + 1, .dimension = dimension, .affine = true, .reference = corners,
                                  .shapes = simplexShapes<dimension>, .gradients = simplexGradients<dimension>,
                                  .hold = holdInSimplex<dimension>};
template <const auto& places, const auto& middles, int dimension>
inline constexpr CellKind quadratic{.nodes = int(places.size()), .dimension = dimension, .order = 2, .reference = places,
                                    .shapes = quadraticShapes<middles, dimension>,
                                    .gradients = quadraticGradients<middles, dimension>, .hold = holdInSimplex<dimension>};
inline constexpr CellKind of_prism{.nodes = 6, .dimension = 3, .reference = prism_nodes, .shapes = prismShapes,
                                   .gradients = prismGradients, .hold = holdInPrism};
inline constexpr CellKind of_pyramid{.nodes = 5, .dimension = 3, .reference = pyramid_nodes, .shapes = pyramidShapes,
                                     .gradients = pyramidGradients, .hold = holdInPyramid};

/// singular, plural, word, alias.
using Words = std::array<std::string_view, 4>;
/// `of_shape`: one of those above; `own`: all other members.
constexpr CellKind kindFrom(CellType type, const Words& words, CellKind of_shape, const CellKind& own) {
  CellKind kind = of_shape;
  kind.type = type, kind.singular = words[0], kind.plural = words[1], kind.word = words[2], kind.alias = words[3];
  kind.edges = own.edges, kind.faces = own.faces, kind.corner_edges = own.corner_edges, kind.rules = own.rules;
  kind.size = own.size, kind.vtk = own.vtk, kind.gmsh = own.gmsh;
  return kind;
}

inline constexpr CellKind point = kindFrom(CellType::point, {"point", "points", "Point"}, simplex<point_nodes, 0>,
                                           {.rules = point_rules, .vtk = format(1, 1), .gmsh = format(15, 1)});
inline constexpr CellKind edge = kindFrom(CellType::edge, {"edge", "edges", "Edge", "lines"}, box<edge_nodes, 1>,
             {.edges = edge_edges, .rules = edge_rules, .size = edgeLength, .vtk = format(3, 2), .gmsh = format(1, 2)});
inline constexpr CellKind triangle = kindFrom(CellType::triangle, {"triangle", "triangles", "Triangle"}, simplex<triangle_nodes, 2>,
    {.edges = triangle_edges, .rules = triangle_rules, .size = triangleArea, .vtk = format(5, 3), .gmsh = format(2, 3)});
inline constexpr CellKind quad = kindFrom(CellType::quad, {"quad", "quads", "Quad"}, box<quad_nodes, 2>,
             {.edges = quad_edges, .rules = quad_rules, .size = quadArea, .vtk = format(9, 4), .gmsh = format(3, 4)});
inline constexpr CellKind tetrahedron =
    kindFrom(CellType::tetrahedron, {"tetrahedron", "tetrahedra", "Tetrahedron", "tetras"}, simplex<tetrahedron_nodes, 3>,
             {.edges = tetrahedron_edges, .faces = tetrahedron_faces, .corner_edges = tetrahedron_corner_edges,
              .rules = tetrahedron_rules, .size = tetrahedronSize, .vtk = format(10, 4), .gmsh = format(4, 4)});
inline constexpr CellKind hexahedron =
    kindFrom(CellType::hexahedron, {"hexahedron", "hexahedra", "Hexahedron", "hexas"}, box<hexahedron_nodes, 3>,
             {.edges = hexahedron_edges, .faces = hexahedron_faces, .corner_edges = hexahedron_corner_edges,
              .rules = hexahedron_rules, .size = hexahedronSize, .vtk = format(12, 8), .gmsh = format(5, 8)});
inline constexpr CellKind quadratic_triangle =
    kindFrom(CellType::quadratic_triangle, {"quadraticTriangle", "quadraticTriangles", "QuadraticTriangle"},
             quadratic<quadratic_triangle_nodes, triangle_middles, 2>,
             {.edges = quadratic_triangle_edges, .rules = quadratic_triangle_rules, .size = quadraticTriangleArea,
              .vtk = format(22, 6), .gmsh = format(9, 6)});
inline constexpr CellKind quadratic_tetrahedron =
    kindFrom(CellType::quadratic_tetrahedron, {"quadraticTetrahedron", "quadraticTetrahedra", "QuadraticTetrahedron"},
             quadratic<quadratic_tetrahedron_nodes, tetrahedron_middles, 3>,
             {.edges = quadratic_tetrahedron_edges, .faces = quadratic_tetrahedron_faces,
              .corner_edges = quadratic_tetrahedron_corner_edges, .rules = quadratic_tetrahedron_rules,
              .size = quadraticTetrahedronSize, .vtk = format(24, 10), .gmsh = format(11, 10, last_two_swapped)});
inline constexpr CellKind prism = kindFrom(CellType::prism, {"prism", "prisms", "Prism", "pentahedra"}, of_prism,
             {.edges = prism_edges, .faces = prism_faces, .corner_edges = prism_corner_edges, .rules = prism_rules,
              .size = prismSize, .vtk = format(13, 6), .gmsh = format(6, 6)});
inline constexpr CellKind pyramid = kindFrom(CellType::pyramid, {"pyramid", "pyramids", "Pyramid"}, of_pyramid,
             {.edges = pyramid_edges, .faces = pyramid_faces, .corner_edges = pyramid_corner_edges, .rules = pyramid_rules,
              .size = pyramidSize, .vtk = format(14, 5), .gmsh = format(7, 5)});

/// By CellType.
inline constexpr std::array<const CellKind*, cell_types> all{
    &point, &edge, &triangle, &quad, &tetrahedron, &hexahedron, &quadratic_triangle, &quadratic_tetrahedron, &prism, &pyramid};

}  // namespace cell_kinds

constexpr const CellKind& kindOf(CellType type) { return *cell_kinds::all[std::size_t(type)]; }

/// The kind that VTK or Gmsh gives this number, or null.
constexpr const CellKind* kindByNumber(CellFormat CellKind::*format, int number) {
  for (const CellKind* kind : cell_kinds::all)
    if ((kind->*format).number == number) return kind;
  return nullptr;
}

}  // namespace stroma
