// SPDX-License-Identifier: LGPL-2.1-or-later
// The faces of the cells of a mesh, turned as in the table of kinds of cells.
#pragma once
#include <vector>

#include "framework/mesh/cell_kind.h"
#include "framework/mesh/mesh.h"

namespace stroma {

/// One face of one cell.
struct CellFace {
  Index cell = 0;  ///< in the order of the lists of cells
  int face = 0;  ///< of CellKind::faces
};

/// Every face of this shape of the volume cells once, or only those of a single cell; turned outward as in the first cell that
/// has it, in ascending order of their sorted nodes.
std::vector<Triangle> uniqueTriangles(const Mesh& mesh, bool boundary_only);
std::vector<Quad> uniqueQuads(const Mesh& mesh, bool boundary_only);
std::vector<QuadraticTriangle> uniqueQuadraticTriangles(const Mesh& mesh, bool boundary_only);

/// Pairs of hexahedra that share a face (the first two cells of it), in ascending order of the face's sorted nodes.
std::vector<std::array<CellFace, 2>> sharedFaces(const std::vector<Hexahedron>& cells);

}  // namespace stroma
