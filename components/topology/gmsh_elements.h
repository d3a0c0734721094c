// SPDX-License-Identifier: LGPL-2.1-or-later
// The elements of a .msh file by Gmsh's numbers: those that are kinds of cells, and those that are known by name only.
#pragma once
#include "components/topology/gmsh_cursor.h"
#include "framework/mesh/cell_kind.h"

namespace stroma {

struct GmshElement {
  const CellKind* kind;   ///< null: read over
  int nodes;              ///< at most most_cell_nodes
  std::string_view name;  ///< plural
};

/// Throws through the cursor for numbers that are not known, and for quadratic elements other than
/// tetrahedra, triangles and edges.
GmshElement gmshElement(int number, const GmshCursor& where);

}  // namespace stroma
