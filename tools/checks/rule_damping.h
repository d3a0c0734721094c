// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "framework/simulation/simulation.h"

namespace stroma {

/// A sentence for each system that has swung, and swings on, while the rule of its integrator, backward Euler, takes more than
/// 3 % of the height of such a swing in a period, unless damping that the scene asks for takes far more; and for each whose
/// steps are longer than its slowest swing, so that none is seen.
std::vector<std::string> dampedSwings(const Simulation& simulation);

}  // namespace stroma
