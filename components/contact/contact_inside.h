// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "components/contact/contact_terms.h"

namespace stroma::contact {

/// The surface of this body, which has an inside, goes around the place.
bool isInside(const Vec3& place, const Surfaces& surfaces, const std::vector<Vec3>& x, int body);

/// Throws ComponentError where an obstacle lies inside of a body of the component at `path`, which distances do not show. One vertex
/// of each piece tells: what crosses a surface is found otherwise (refuseOverlap()). x: of all vertices. With `name`, which says
/// what a vertex is, bodies inside of others are refused too.
void refuseInside(const std::string& path, const Surfaces& surfaces, const std::vector<Vec3>& x,
                  const std::function<std::string(int)>& name = {});

/// A sentence where bodies start nearer to each other than the gap that is kept, the range of the law; else nothing.
std::string describeNear(const BarrierLaw& law, const std::vector<Vec3>& x, const std::function<std::string(int)>& nameOf);

}  // namespace stroma::contact
