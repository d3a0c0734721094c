// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/mesh/cell_kind.h"

namespace stroma {

/// Of a volume cell with nodes at x, shape (nodes): 1 for the regular cell, 0 flat, < 0 inverted. Of a tetrahedron the mean ratio
/// sign(V) 12 (3 |V|)^(2/3) / (sum of squared edge lengths), of a quadratic one that of its corners times the least det dx/dxi at a
/// node over that of the flat cell. Of a hexahedron, prism or pyramid the worst of the tetrahedra at its corners over the best that
/// all of them can be: those of a cube; 0.996 and 0.963 where all edges are alike.
double cellQuality(const CellKind& kind, const Vec3* x);

}  // namespace stroma
