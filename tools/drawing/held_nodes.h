// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "tools/drawing/body.h"

namespace stroma::drawing {

/// What a constraint does to a node.
enum class Holding : char { free, guided, held };

/// By body and page number: what constraints of the scene do to the nodes in the step that begins at t [s].
std::vector<std::vector<Holding>> holdingsOf(const Simulation& simulation, const Drawing& drawing, double t);

}  // namespace stroma::drawing
