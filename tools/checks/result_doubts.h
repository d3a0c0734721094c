// SPDX-License-Identifier: LGPL-2.1-or-later
// What may be no result, of a run as it stands.
#pragma once
#include <string>
#include <vector>

#include "framework/simulation/simulation.h"

namespace stroma {

/// Why the present shapes may be no result: a sentence for each force field with elements that are flat or inverted
/// (a body may come to rest so) or strained beyond its law, for each elastic body far larger than at rest, for an
/// energy that came from nowhere, for velocities that change sign from step to step (from the 17th step on), for a
/// mesh that has folded over itself where no force field looks at its volumes, for a body that lies still with more energy
/// than its rest shape has, for what follows by a constraint and pulls without being felt, and for what an integrator
/// reports.
std::vector<std::string> doubtsOf(const Simulation& simulation);

/// Why the next step would be refused, of a run that ends before it: bodies that have come to touch in the last one, where
/// nothing answers, are as wrong as those that would have ended it.
std::vector<std::string> refusedFromHere(const Simulation& simulation);

/// How many volume elements of the states that move have no volume left, and of how many.
struct CellCount {
  std::size_t inverted = 0, all = 0;
};
CellCount invertedCells(const Simulation& simulation);

/// A warning for each force that is a step late under an integrator that does not bear it.
void warnOfLaggedForces(const Simulation& simulation, Diagnostics& diagnostics);

}  // namespace stroma
