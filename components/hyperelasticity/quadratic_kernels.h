// SPDX-License-Identifier: LGPL-2.1-or-later
// Quadratic tetrahedra of a hyperelastic law, compiled once for all laws: the law's part of a point is behind functions
// (point_functions.h).
#pragma once
#include "components/hyperelasticity/hyperelastic_law.h"

namespace stroma::hyperelastic {

struct QuadraticKernels {
  std::unique_ptr<ElementKernels> (*make)(const HyperelasticLaw& law, const Cells& cells) = nullptr;
};
/// Empty until a module has offered them.
QuadraticKernels& quadraticKernels();

}  // namespace stroma::hyperelastic
