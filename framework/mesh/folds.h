// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "framework/mesh/mesh.h"

namespace stroma {

/// How a deformed mesh has folded over itself, as a sentence with the number of places and the first of them, or empty:
/// a tetrahedron or a corner of a hexahedron inside out; upright cells that fill the space around a node more than
/// once; without volume cells: neighbours of a surface, or the two sides of a node of a chain of edges, that make an
/// angle below 60 degrees where it was above 90 at rest. `rest` and `now` [m] have shape (mesh.nodes()).
std::string foldsOf(const Mesh& mesh, const std::vector<Vec3>& rest, const std::vector<Vec3>& now);

/// The same for chains of edges alone: nodes where two of them meet, and no third one.
std::string foldsOf(const std::vector<Edge>& edges, const std::vector<Vec3>& rest, const std::vector<Vec3>& now);

}  // namespace stroma
