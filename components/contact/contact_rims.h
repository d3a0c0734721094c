// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "components/contact/contact_terms.h"

namespace stroma::contact {

/// Contacts of vertices beside the sharp rim of a surface that their own surface goes along. Their normal leans along the way on which
/// they slide below the surface or off it. As normals last for a step, it would stop them there, or throw them. A vertex is pushed as it
/// will be there; what is far beside waits until it is there. `x`: places of all vertices, where `touches` were found.
void leaveRims(const BarrierLaw& law, const std::vector<Vec3>& x, std::vector<Touch>& touches);

}  // namespace stroma::contact
