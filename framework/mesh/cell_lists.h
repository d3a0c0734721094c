// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <utility>
#include <vector>

#include "framework/mesh/cell_kind.h"
#include "framework/mesh/mesh.h"

namespace stroma {

/// Something for each kind of cell that a mesh lists, under the names of the mesh.
template <class T>
struct PerCellList {
  T edges{}, triangles{}, quads{}, quadratic_triangles{}, tetrahedra{}, hexahedra{}, prisms{}, pyramids{}, quadratic_tetrahedra{};
};

/// Calls visit(kind, list...) for each kind that a mesh lists, with its list in each of `holders`: meshes, or whatever
/// has members of the same names. Ascending in dimension; tetrahedra, hexahedra, prisms, pyramids, quadratic cells last.
template <class Visit, class... Holders>
void forEachCellList(Visit&& visit, Holders&&... holders) {
  visit(cell_kinds::edge, holders.edges...);
  visit(cell_kinds::triangle, holders.triangles...);
  visit(cell_kinds::quad, holders.quads...);
  visit(cell_kinds::quadratic_triangle, holders.quadratic_triangles...);
  visit(cell_kinds::tetrahedron, holders.tetrahedra...);
  visit(cell_kinds::hexahedron, holders.hexahedra...);
  visit(cell_kinds::prism, holders.prisms...);
  visit(cell_kinds::pyramid, holders.pyramids...);
  visit(cell_kinds::quadratic_tetrahedron, holders.quadratic_tetrahedra...);
}

/// 3 for a mesh with volume cells, 2 for a surface, 1 for lines, 0 without cells.
inline int highestDimension(const Mesh& mesh) {
  int highest = 0;
  forEachCellList([&](const CellKind& kind, const auto& cells) { highest = cells.empty() ? highest : kind.dimension; }, mesh);
  return highest;
}

/// The positions of a cell's nodes.
template <class Cell>
std::array<Vec3, std::tuple_size_v<Cell>> cornersOf(const Cell& cell, const std::vector<Vec3>& position) {
  std::array<Vec3, std::tuple_size_v<Cell>> corners;
  for (std::size_t a = 0; a < cell.size(); ++a) corners[a] = position[cell[a]];
  return corners;
}

}  // namespace stroma
