// SPDX-License-Identifier: LGPL-2.1-or-later
// A contact of whole surfaces as the response to all contacts of a scene: BarrierContact, ConstraintContact or PenaltyContact. The
// CollisionResponse asks for one beside itself (Component::missingPartner()), and the collision models of the scene become its bodies:
//   states of active models that may meet   mstate, other
//   groups, selfCollision, simulated        excludedPairs, selfContact
//   contactDistance of the method           contactDistance
//   contactDistance of models               thickness, or radii if they differ
//   mu=... of responseParams                friction; other parameters are attributes of the contact
// What cannot be carried over is an error that names it, and what has no meaning there a warning.
#pragma once
#include <string_view>

#include "components/collision/collision_method.h"

namespace stroma::collision {

/// Whether a response is one of these.
bool isOfSurfaces(std::string_view response);

/// Sets the attributes of `contact` for `response`, a CollisionResponse. Throws ComponentError.
void describeContact(Component& contact, const Component& response, const Method* method, const std::string& parameters);

}  // namespace stroma::collision
