// SPDX-License-Identifier: LGPL-2.1-or-later
// Points in the cells of a body as SOFA's BarycentricMapping finds them.
//
// A point has affine coordinates u in each cell, of the edges from its first corner (of hexahedra 1, 3, 4, of quads 1, 3), and across
// a surface those of the product of both. It belongs to a cell that holds it, the one in which it lies deepest, else to the cell whose
// centre is nearest; its weights are the shape functions at u, wherever that lies. In a set container the cells are those whose boxes
// meet the point's cell of a grid as wide as the mean edge, with its neighbours when none of these is near, else all. In a regular
// grid a point outside belongs to the nearest cell.
#pragma once
#include <vector>

#include "components/mappings/cell_embedding.h"

namespace stroma {

/// Whether SOFA finds cells so in this mesh: tetrahedra, hexahedra, triangles or quads, but not those of sparse grids.
bool findsByCentres(const Topology& topology);
/// Their nodes lie at `body`. `size` as of embedPoints(); without slopes. Distances are those from the boxes of the cells.
std::vector<EmbeddedPoint> embedByCentres(const Topology& topology, const std::vector<Vec3>& body, const std::vector<Vec3>& points,
                                          double& size);

}  // namespace stroma
