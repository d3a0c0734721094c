// SPDX-License-Identifier: LGPL-2.1-or-later
// What subcommands share that show a scene: `stroma view` and `stroma picture`.
#pragma once
#include <string>

#include "framework/simulation/simulation.h"

namespace stroma::command {

/// Observers write nothing. A note says so, unless `why` ("in a view") is empty.
void leaveOutputs(Simulation& simulation, const std::string& why);

}  // namespace stroma::command
