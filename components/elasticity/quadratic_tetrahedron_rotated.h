// SPDX-License-Identifier: LGPL-2.1-or-later
// The kernels of one rotation, for the source that instantiates them.
#pragma once
#include "components/elasticity/quadratic_tetrahedron_exact.h"
#include "components/elasticity/quadratic_tetrahedron_kernels.h"

namespace stroma::quadratic_tetrahedron {

template <class Rotation>
std::unique_ptr<ElementKernels> rotatedKernels(const Elements& elements) {
  if (elements.variant.exact_tangent) return kernelsOf<ExactCorotational<Rotation>>(elements);
  return kernelsOf<Corotational<Rotation>>(elements);
}

}  // namespace stroma::quadratic_tetrahedron
