// SPDX-License-Identifier: LGPL-2.1-or-later
// Attributes of friction and adhesion, shared by the contact components.
#pragma once
#include "components/contact/contact_friction.h"

namespace stroma::contact {

void declareFriction(DataTable& table, Friction& friction);
/// staticFriction defaults to friction. Throws ComponentError if it is smaller.
void finishFriction(Friction& friction);

void declareAdhesion(DataTable& table, Adhesion& adhesion, Friction& friction);
/// Gaps default to multiples of contactDistance, `range`. Throws ComponentError for inconsistent values.
void finishAdhesion(Adhesion& adhesion, const Friction& friction, double range);

}  // namespace stroma::contact
