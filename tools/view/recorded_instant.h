// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "tools/view/viewer.h"

namespace stroma::view {

/// Gives all states the positions of an instant of the recording, and its velocities where there are any.
void showInstant(Simulation& simulation, const Recording& recording, std::size_t instant);

}  // namespace stroma::view
