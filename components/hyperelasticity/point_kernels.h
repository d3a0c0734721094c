// SPDX-License-Identifier: LGPL-2.1-or-later
// Cells with several integration points, compiled once for all laws (point_law.h).
#pragma once
#include "components/hyperelasticity/hyperelastic_law.h"

namespace stroma::hyperelastic {

/// Null for a form that these cells do not have.
struct PointKernels {
  std::unique_ptr<ElementKernels> (*hexahedra)(const HyperelasticLaw& law, const Cells& cells) = nullptr;
  std::unique_ptr<ElementKernels> (*quadratic_tetrahedra)(const HyperelasticLaw& law, const Cells& cells) = nullptr;
};
/// Empty until a module has offered them.
PointKernels& pointKernels();

}  // namespace stroma::hyperelastic
