// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "components/contact/contact_surfaces.h"

namespace stroma::contact {

/// The largest youngModulus of the force fields below the nodes of these states, or of the nearest nodes above that have
/// one below; 0: none has [Pa].
double largestYoungModulus(const std::vector<State*>& bodies);

/// "node 3 of /body/dofs", or "an obstacle". `bodies`: the states of the surfaces, in their order.
std::string nameOfVertex(const Surfaces& surfaces, const std::vector<State*>& bodies, int vertex);

}  // namespace stroma::contact
