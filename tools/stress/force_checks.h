// SPDX-License-Identifier: LGPL-2.1-or-later
// What forces, energies, their derivatives and mappings owe each other, whatever they compute:
//   f = -dE/dx     where a field says that it has an energy
//   K dx = df      to some digits where its derivative is said to be exact; else near the start, to a quarter inside a body,
//                  and of the right sign elsewhere; the same for C dv = df of forces that depend on velocities
//   matrix, diagonal and the pass that makes force and product together are those of the product
//   sums of forces and torques are zero where it says so, and equal positions give equal forces
//   where cells are inside out, J is not positive, and a force that is no number has an element to blame
//   J dx = dphi, f . J dx = J^T f . dx     of mappings
// Derivatives are central differences in directions at random; where two steps of the difference disagree, as at a contact that
// begins, nothing is concluded.
#pragma once
#include <string>
#include <vector>

#include "framework/simulation/simulation.h"

namespace stroma::stress {

/// A sentence for each promise that is broken at the present positions, with path and place of the component. `near_start`:
/// derivatives that are approximate by design are looked at too.
std::vector<std::string> brokenPromises(const Simulation& simulation, bool near_start, unsigned seed);

}  // namespace stroma::stress
