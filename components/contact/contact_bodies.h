// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "components/contact/contact_surfaces.h"

namespace stroma::contact {

/// The largest youngModulus of the force fields of these states and below; 0: none has one [Pa].
double largestYoungModulus(const std::vector<State*>& bodies);

/// "node 3 of /body/dofs", or "an obstacle".
std::string nameOfVertex(const Surfaces& surfaces, const std::vector<State*>& bodies, int vertex);

/// Present positions of all vertices, obstacles moved by `moved`.
std::vector<Vec3> presentPositions(const Surfaces& surfaces, const std::vector<State*>& bodies, const Vec3& moved);

}  // namespace stroma::contact
