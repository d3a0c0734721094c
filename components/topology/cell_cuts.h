// SPDX-License-Identifier: LGPL-2.1-or-later
// Cutting hexahedra into tetrahedra.
#pragma once
#include <optional>
#include <vector>

#include "framework/scene/types.h"

namespace stroma {

/// How a hexahedron is cut.
/// - six: around the diagonal from corner 0 to corner 6, as SOFA does.
/// - five1, five2: the two ways to cut into five of Nesme et al. 2005, appendix B; every cell alike, so the faces of
///   neighbours do not match.
/// - five: five1 and five2 in turn, chosen so that all faces match.
/// - ten: five1 and five2 superposed; the cells cover the body twice (Mesh::overlap 2).
/// - mirrored: six, each cell's the mirror images of its neighbours' corner by corner, so that every other cell has
///   tetrahedra of negative volume; cells need the layout of a grid.
enum class HexahedronCut : int { six, five, five1, five2, ten, mirrored };

/// Tetrahedra that a hexahedron gives.
int tetrahedraPerHexahedron(HexahedronCut cut);

/// The tetrahedra of hexahedron h are [n h, n h + n), all of positive volume in a convex cell but for the cut mirrored. With
/// `mirrored` (six only) the cut of each cell is the mirror image of its neighbours', so that no diagonal is preferred: cells
/// need the layout of a grid. Throws ComponentError when a cut cannot be made to match.
std::vector<Tetrahedron> cutHexahedra(const std::vector<Hexahedron>& hexahedra, HexahedronCut cut,
                                      bool mirrored = false);

/// Number of faces shared by two hexahedra that the tetrahedra cut along different diagonals: the mesh has a crack
/// there. `per_cell` tetrahedra for each hexahedron, in order.
Index mismatchedFaces(const std::vector<Hexahedron>& hexahedra, const std::vector<Tetrahedron>& tetrahedra,
                      int per_cell);

/// The place of each cell in the grid that they form, counted from the first cell of each connected part, or nothing
/// when neighbours are not laid out like cells of a grid (each cell's +x face being the next one's -x face, corner by
/// corner).
std::optional<std::vector<std::array<int, 3>>> gridPlaces(const std::vector<Hexahedron>& hexahedra);

}  // namespace stroma
