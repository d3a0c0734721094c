// SPDX-License-Identifier: LGPL-2.1-or-later
// The edges and faces of cells, by corner. Faces turn counter-clockwise seen from outside a cell of positive volume.
#pragma once
#include <vector>

#include "framework/scene/types.h"

namespace stroma {

constexpr std::array<std::array<int, 2>, 6> tetrahedron_edges{{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};
/// Face i is opposite corner i.
constexpr std::array<std::array<int, 3>, 4> tetrahedron_faces{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

constexpr std::array<std::array<int, 2>, 12> hexahedron_edges{
    {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6}, {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}}};
/// In the order -z, +z, -y, +x, +y, -x of the unit cube.
constexpr std::array<std::array<int, 4>, 6> hexahedron_faces{
    {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}};
/// The three corners joined to a corner by an edge, right-handed: their tetrahedron with the corner has the sign of
/// the cell there.
constexpr std::array<std::array<int, 3>, 8> hexahedron_corner_edges{
    {{1, 3, 4}, {2, 0, 5}, {3, 1, 6}, {0, 2, 7}, {7, 5, 0}, {4, 6, 1}, {5, 7, 2}, {6, 4, 3}}};

/// One face of one cell.
struct CellFace {
  Index cell = 0;
  int face = 0;
};

/// Every face of the cells once, or only those of a single cell; turned outward as in the first cell that has it, in
/// ascending order of their sorted nodes.
std::vector<Triangle> uniqueFaces(const std::vector<Tetrahedron>& cells, bool boundary_only);
std::vector<Quad> uniqueFaces(const std::vector<Hexahedron>& cells, bool boundary_only);

/// Pairs of hexahedra that share a face (the first two cells of it), in ascending order of the face's sorted nodes.
std::vector<std::array<CellFace, 2>> sharedFaces(const std::vector<Hexahedron>& cells);

}  // namespace stroma
