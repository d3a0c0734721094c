// SPDX-License-Identifier: LGPL-2.1-or-later
// Attributes of friction and adhesion, which contacts share.
#pragma once
#include "components/contact/contact_friction.h"

namespace stroma::contact {

void declareFriction(DataTable& table, Friction& friction);
/// staticFriction that is not given is friction. Throws ComponentError where it is smaller.
void finishFriction(Friction& friction);

void declareAdhesion(DataTable& table, Adhesion& adhesion, Friction& friction);
/// Gaps that are not given follow contactDistance, `range`. Throws ComponentError for others that make no sense.
void finishAdhesion(Adhesion& adhesion, const Friction& friction, double range);

}  // namespace stroma::contact
