// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "framework/mesh/mesh.h"

namespace stroma {

/// How the volume cells of a deformed mesh have folded over each other, as a sentence with the number of places and the
/// first of them, or empty: tetrahedra, corners of hexahedra, nodes or centres of quadratic tetrahedra inside out; upright
/// cells that fill the space around a node more than once. Of a surface without volume cells: faces that are crushed to a
/// line; its folds are not looked at, and lines neither: cloth and ropes fold. `rest` and `now` [m] have shape (mesh.nodes()).
std::string foldsOf(const Mesh& mesh, const std::vector<Vec3>& rest, const std::vector<Vec3>& now);

/// How many volume cells are inside out as above, and of how many.
std::pair<std::size_t, std::size_t> insideOutCells(const Mesh& mesh, const std::vector<Vec3>& rest,
                                                   const std::vector<Vec3>& now);

}  // namespace stroma
