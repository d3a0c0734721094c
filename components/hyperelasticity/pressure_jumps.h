// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "components/hyperelasticity/porous_cells.h"

namespace stroma::porous {

/// Pressures that go up and down from node to node below a drained surface. Before the fluid has come out of the first cells a
/// pressure that is linear on cells cannot follow its drop there: elements only feel the mean of their nodes, and the node below the
/// surface takes twice the pressure, the next one none, and so on (for steps h below d^2/(4 kappa E), d the size of the cells and E
/// the tissue's K + 4G/3: Vermeer and Verruijt 1981).
struct PressureJump {
  Index node = -1;                ///< that below the surface; -1: there is none
  double here = 0, beneath = 0;  ///< pressures of it and of the next one [Pa]
};

/// The largest jump of which both nodes have neighbours that are all on the other side of them, and that goes on beyond them.
PressureJump pressureJump(const PorousCells& cells, const std::vector<double>& pressure, const std::vector<char>& drained);

}  // namespace stroma::porous
