// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "framework/simulation/state_file.h"

namespace stroma {
class Simulation;
}

namespace stroma::drawing {

/// The instants of a recorded run, for each state of the simulation in its order. All states have the same times.
using Recording = std::vector<std::vector<StateFrame>>;

/// Gives all states the positions of an instant of the recording, and its velocities where there are any.
void showInstant(Simulation& simulation, const Recording& recording, std::size_t instant);

}  // namespace stroma::drawing
