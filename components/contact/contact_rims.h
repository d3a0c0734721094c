// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "components/contact/contact_terms.h"

namespace stroma::contact {

/// Corrects contacts of vertices beside a sharp rim of a surface along which their own surface extends. Their normal is inclined along
/// the direction in which they slide below the surface or off it. Because normals are fixed for a step, this would stop or throw them.
/// Such a vertex is pushed as it will be at the rim; one far beside it is not pushed yet. `x`: positions of all vertices for `touches`.
void leaveRims(const BarrierLaw& law, const std::vector<Vec3>& x, std::vector<Touch>& touches);

}  // namespace stroma::contact
