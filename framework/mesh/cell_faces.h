// SPDX-License-Identifier: LGPL-2.1-or-later
// The faces of the cells of a mesh, turned as in the table of kinds of cells.
#pragma once
#include <vector>

#include "framework/mesh/cell_kind.h"
#include "framework/mesh/mesh.h"

namespace stroma {

/// Every face of this shape of the volume cells once, or only those of a single cell; oriented outward as in the first cell
/// that has it, in ascending order of their sorted nodes.
std::vector<Triangle> uniqueTriangles(const Mesh& mesh, bool boundary_only);
std::vector<Quad> uniqueQuads(const Mesh& mesh, bool boundary_only);
std::vector<QuadraticTriangle> uniqueQuadraticTriangles(const Mesh& mesh, bool boundary_only);

}  // namespace stroma
