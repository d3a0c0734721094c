// SPDX-License-Identifier: LGPL-2.1-or-later
// What is compiled once for all laws: cells with several integration points (point_law.h), and linear tetrahedra in the forms
// standard and projected (fan_law.h).
#pragma once
#include "components/hyperelasticity/hyperelastic_law.h"

namespace stroma::hyperelastic {

/// Null for a form that these cells do not have.
struct PointKernels {
  std::unique_ptr<ElementKernels> (*hexahedra)(const HyperelasticLaw& law, const Cells& cells) = nullptr;
  std::unique_ptr<ElementKernels> (*quadratic_tetrahedra)(const HyperelasticLaw& law, const Cells& cells) = nullptr;
  /// In the forms standard and projected; the others are the law's own.
  std::unique_ptr<ElementKernels> (*tetrahedra)(const HyperelasticLaw& law, const Cells& cells) = nullptr;
};
/// Empty until a module has offered them.
PointKernels& pointKernels();

}  // namespace stroma::hyperelastic
