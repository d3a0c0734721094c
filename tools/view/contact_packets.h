// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "tools/view/drawn.h"
#include "tools/view/packet.h"

namespace stroma::view {

/// To the packet of a scene: obstacles with their triangles, and the contacts that there are.
void describeContacts(const Drawing& drawing, Packet& packet);

/// To the packet of a frame: where obstacles are, and where a hand leads them.
void addObstaclePlaces(const Drawing& drawing, Packet& packet);
/// To the same: forces of contact, and their sums on bodies and between them.
void addContactForces(const Drawing& drawing, Packet& packet);

}  // namespace stroma::view
