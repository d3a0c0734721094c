// SPDX-License-Identifier: LGPL-2.1-or-later
// The kernels of one rotation, for the source that instantiates them.
#pragma once
#include "components/elasticity/point_cells.h"
#include "components/elasticity/point_exact.h"

namespace stroma {

template <class S, class Rotation>
std::unique_ptr<ElementKernels> rotatedKernels(const PointElementsOf<S>& elements) {
  if (elements.variant.exact_tangent) return kernelsOf<elastic::ExactCorotational<S, Rotation>>(elements);
  return kernelsOf<typename elastic::PointModels<S>::template Corotational<Rotation>>(elements);
}

}  // namespace stroma
