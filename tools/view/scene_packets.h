// SPDX-License-Identifier: LGPL-2.1-or-later
// What is sent of a scene once: bodies, fields, cells; and what holds nodes.
#pragma once
#include "tools/view/drawn.h"
#include "tools/view/packet.h"

namespace stroma::view {

Packet scenePacket(const Simulation& simulation, const Drawing& drawing, int generation, const std::string& mode);
/// Connectivity of all volume cells, for cuts.
Packet cellsPacket(const Drawing& drawing, int generation);
/// Nodes that constraints of the scene hold or guide in the step that begins at t [s].
Packet heldPacket(const Simulation& simulation, const Drawing& drawing, int generation, double t);
/// Grows when another heldPacket() may be due.
long heldRevision(const Simulation& simulation);

}  // namespace stroma::view
