// SPDX-License-Identifier: LGPL-2.1-or-later
// What a kind of cell is, in one table: names, numbering, shape functions, quadrature, and how files number it. Meshes,
// loaders, masses, mappings and exporters read it; a further kind is one more entry.
//
// x(xi) = sum_a N_a(xi) x_a maps the reference cell to the cell. Boxes (edge, quad, hexahedron) have -1 <= xi_i <= 1 and
//   N_a = prod_i (1 + s_ai xi_i) / 2,   s_a the coordinates of node a,
// simplices (triangle, tetrahedron) xi_i >= 0, sum xi_i <= 1 and N_0 = 1 - sum xi_i, N_i = xi_i. With l_a these N_a, the
// quadratic simplices have N_a = l_a (2 l_a - 1) at corners and 4 l_a l_b at the node between corners a and b.
#pragma once
#include <string_view>

#include "framework/mesh/cell_tables.h"

namespace stroma {

struct CellKind {
  CellType type;
  std::string_view singular, plural;  ///< "tetrahedron", "tetrahedra"
  std::string_view word;              ///< in template="Vec3,Tetrahedron"
  std::string_view alias{};           ///< SOFA's second word for a list of these cells ("tetras"), or empty
  int nodes, dimension;
  int order = 1;                          ///< degree of the shape functions
  bool affine;                            ///< x(xi) is affine, whatever the nodes: a simplex
  std::span<const LocalPoint> reference;  ///< xi of the nodes
  std::span<const std::array<int, 2>>
      edges{};  ///< by local nodes, halves in quadratic cells; of triangles and quads all the way round
  std::span<const LocalFace> faces{};  ///< of volume cells
  /// Of volume cells: the three nodes joined to a corner by an edge, right-handed. Their tetrahedron with the node has the
  /// sign of the cell there.
  std::span<const std::array<int, 3>> corner_edges{};
  std::span<const QuadratureRule> rules;                        ///< ascending in degree
  void (*shapes)(const LocalPoint& xi, double* n);              ///< N_a, shape (nodes)
  void (*gradients)(const LocalPoint& xi, LocalPoint* slopes);  ///< dN_a/dxi, shape (nodes)
  void (*hold)(LocalPoint& xi);  ///< moves a point outside of the reference cell to its border
  /// Length [m], area [m^2] or signed volume [m^3] of the cell with nodes at x, shape (nodes); null for points.
  double (*size)(const Vec3* x) = nullptr;
  /// Of volume cells, else null: 1 for the regular cell, 0 flat, < 0 inverted. Of a tetrahedron the mean ratio
  /// sign(V) 12 (3 |V|)^(2/3) / (sum of squared edge lengths); of a hexahedron the worst of the tetrahedra at its
  /// corners, scaled so that a cube has 1.
  double (*quality)(const Vec3* x) = nullptr;
  CellFormat vtk, gmsh;

  /// The rule with the fewest points that is exact for this degree; the last when there is none.
  constexpr const QuadratureRule& rule(int degree) const {
    for (const QuadratureRule& candidate : rules)
      if (candidate.degree >= degree) return candidate;
    return rules.back();
  }
};

namespace cell_kinds {

using namespace cell_tables;  // NOLINT(google-build-using-namespace): one table in two files

inline constexpr CellKind point{
    .type = CellType::point,
    .singular = "point",
    .plural = "points",
    .word = "Point",
    .nodes = 1,
    .dimension = 0,
    .affine = true,
    .reference = point_nodes,
    .rules = point_rules,
    .shapes = simplexShapes<0>,
    .gradients = simplexGradients<0>,
    .hold = holdInSimplex<0>,
    .vtk = format(1, 1),
    .gmsh = format(15, 1),
};
inline constexpr CellKind edge{
    .type = CellType::edge,
    .singular = "edge",
    .plural = "edges",
    .word = "Edge",
    .alias = "lines",
    .nodes = 2,
    .dimension = 1,
    .affine = true,
    .reference = edge_nodes,
    .edges = edge_edges,
    .rules = edge_rules,
    .shapes = boxShapes<edge_nodes, 1>,
    .gradients = boxGradients<edge_nodes, 1>,
    .hold = holdInBox<1>,
    .size = edgeLength,
    .vtk = format(3, 2),
    .gmsh = format(1, 2),
};
inline constexpr CellKind triangle{
    .type = CellType::triangle,
    .singular = "triangle",
    .plural = "triangles",
    .word = "Triangle",
    .nodes = 3,
    .dimension = 2,
    .affine = true,
    .reference = triangle_nodes,
    .edges = triangle_edges,
    .rules = triangle_rules,
    .shapes = simplexShapes<2>,
    .gradients = simplexGradients<2>,
    .hold = holdInSimplex<2>,
    .size = triangleArea,
    .vtk = format(5, 3),
    .gmsh = format(2, 3),
};
inline constexpr CellKind quad{
    .type = CellType::quad,
    .singular = "quad",
    .plural = "quads",
    .word = "Quad",
    .nodes = 4,
    .dimension = 2,
    .affine = false,
    .reference = quad_nodes,
    .edges = quad_edges,
    .rules = quad_rules,
    .shapes = boxShapes<quad_nodes, 2>,
    .gradients = boxGradients<quad_nodes, 2>,
    .hold = holdInBox<2>,
    .size = quadArea,
    .vtk = format(9, 4),
    .gmsh = format(3, 4),
};
inline constexpr CellKind tetrahedron{
    .type = CellType::tetrahedron,
    .singular = "tetrahedron",
    .plural = "tetrahedra",
    .word = "Tetrahedron",
    .alias = "tetras",
    .nodes = 4,
    .dimension = 3,
    .affine = true,
    .reference = tetrahedron_nodes,
    .edges = tetrahedron_edges,
    .faces = tetrahedron_faces,
    .corner_edges = tetrahedron_corner_edges,
    .rules = tetrahedron_rules,
    .shapes = simplexShapes<3>,
    .gradients = simplexGradients<3>,
    .hold = holdInSimplex<3>,
    .size = tetrahedronSize,
    .quality = tetrahedronShape,
    .vtk = format(10, 4),
    .gmsh = format(4, 4),
};
inline constexpr CellKind hexahedron{
    .type = CellType::hexahedron,
    .singular = "hexahedron",
    .plural = "hexahedra",
    .word = "Hexahedron",
    .alias = "hexas",
    .nodes = 8,
    .dimension = 3,
    .affine = false,
    .reference = hexahedron_nodes,
    .edges = hexahedron_edges,
    .faces = hexahedron_faces,
    .corner_edges = hexahedron_corner_edges,
    .rules = hexahedron_rules,
    .shapes = boxShapes<hexahedron_nodes, 3>,
    .gradients = boxGradients<hexahedron_nodes, 3>,
    .hold = holdInBox<3>,
    .size = hexahedronSize,
    .quality = hexahedronShape,
    .vtk = format(12, 8),
    .gmsh = format(5, 8),
};

inline constexpr CellKind quadratic_triangle{
    .type = CellType::quadratic_triangle,
    .singular = "quadraticTriangle",
    .plural = "quadraticTriangles",
    .word = "QuadraticTriangle",
    .nodes = 6,
    .dimension = 2,
    .order = 2,
    .affine = false,
    .reference = quadratic_triangle_nodes,
    .edges = quadratic_triangle_edges,
    .rules = quadratic_triangle_rules,
    .shapes = quadraticShapes<triangle_middles, 2>,
    .gradients = quadraticGradients<triangle_middles, 2>,
    .hold = holdInSimplex<2>,
    .size = quadraticTriangleArea,
    .vtk = format(22, 6),
    .gmsh = format(9, 6),
};
inline constexpr CellKind quadratic_tetrahedron{
    .type = CellType::quadratic_tetrahedron,
    .singular = "quadraticTetrahedron",
    .plural = "quadraticTetrahedra",
    .word = "QuadraticTetrahedron",
    .nodes = 10,
    .dimension = 3,
    .order = 2,
    .affine = false,
    .reference = quadratic_tetrahedron_nodes,
    .edges = quadratic_tetrahedron_edges,
    .faces = quadratic_tetrahedron_faces,
    .corner_edges = quadratic_tetrahedron_corner_edges,
    .rules = quadratic_tetrahedron_rules,
    .shapes = quadraticShapes<tetrahedron_middles, 3>,
    .gradients = quadraticGradients<tetrahedron_middles, 3>,
    .hold = holdInSimplex<3>,
    .size = quadraticTetrahedronSize,
    .quality = quadraticTetrahedronShape,
    .vtk = format(24, 10),
    .gmsh = format(11, 10, last_two_swapped),
};

/// By CellType.
inline constexpr std::array<const CellKind*, cell_types> all{
    &point, &edge, &triangle, &quad, &tetrahedron, &hexahedron, &quadratic_triangle, &quadratic_tetrahedron};

}  // namespace cell_kinds

constexpr const CellKind& kindOf(CellType type) { return *cell_kinds::all[std::size_t(type)]; }

/// The kind that VTK or Gmsh gives this number, or null.
constexpr const CellKind* kindByNumber(CellFormat CellKind::*format, int number) {
  for (const CellKind* kind : cell_kinds::all)
    if ((kind->*format).number == number) return kind;
  return nullptr;
}

}  // namespace stroma
