// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "components/contact/contact_terms.h"

namespace stroma::contact {

/// Whether the closed surface of this body encloses the point.
bool isInside(const Vec3& place, const Surfaces& surfaces, const std::vector<Vec3>& x, int body);

/// Throws ComponentError if an obstacle is inside a body of the component at `path`, which distances do not reveal. It tests one
/// vertex per piece: intersecting surfaces are found by refuseOverlap(). x: of all vertices. With `name`, which describes a
/// vertex, bodies inside other bodies are errors too.
void refuseInside(const std::string& path, const Surfaces& surfaces, const std::vector<Vec3>& x,
                  const std::function<std::string(int)>& name = {});

/// A warning if bodies start closer than the gap kept by the contact, the range of the law; otherwise empty.
std::string describeNear(const BarrierLaw& law, const std::vector<Vec3>& x, const std::function<std::string(int)>& nameOf);

}  // namespace stroma::contact
