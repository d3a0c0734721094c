// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <map>
#include <string>
#include <vector>

#include "framework/simulation/state_file.h"

namespace stroma {
class Component;
class Simulation;
}

namespace stroma::drawing {

/// The instants of a recorded run, for each state of the simulation in its order, then for each component of withNodeValues(): what it
/// computed, or nothing. All that is not empty has the same times.
using Recording = std::vector<std::vector<StateFrame>>;

/// The file that holds what a component of a recorded run computed: "/body/contact" gives "body.contact.values.gz".
std::string valuesFileName(const std::string& component_path);
/// What a component computed, as numbers, by name.
std::map<std::string, std::vector<double>> valuesOf(const Component& component);

/// Gives all states the positions of an instant of the recording, and its velocities where there are any; and components what they
/// computed, unless a change of meshes has left some out. The simulation has the meshes of the instant.
void showInstant(Simulation& simulation, const Recording& recording, std::size_t instant);

}  // namespace stroma::drawing
