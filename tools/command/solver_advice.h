// SPDX-License-Identifier: LGPL-2.1-or-later
// What a run would have saved without the solver, the tangent or the forcing term that its scene names.
#pragma once
#include <string>
#include <vector>

#include "framework/simulation/simulation.h"
#include "tools/session/statistics.h"

namespace stroma::command {

/// A sentence for each thing that a scene names and that is far from what the run would have chosen, with the attribute or element to
/// leave out. Costs are those of the model by which solvers are chosen, with the iterations and factorisations of the run. Runs whose
/// solves took less than a second get none, nor do those that share their counts among several systems.
std::vector<std::string> solverAdvice(const Simulation& simulation, const RunStatistics& statistics);

}  // namespace stroma::command
