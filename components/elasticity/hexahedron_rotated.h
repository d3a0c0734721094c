// SPDX-License-Identifier: LGPL-2.1-or-later
// The kernels of one rotation, for the source that instantiates them.
#pragma once
#include "components/elasticity/hexahedron_kernels.h"

namespace stroma::hexahedron {

template <class Rotation>
std::unique_ptr<ElementKernels> rotatedKernels(const Elements& elements) {
  if (elements.boxes) return kernelsOf<ModalCorotational<Boxes, Rotation>>(elements);
  const ElasticVariant& variant = elements.shapes.variant();
  return makeUpdated(variant, [&]<Update update>() -> std::unique_ptr<ElementKernels> {
    if (variant.exact_tangent) return kernelsOf<ExactPointCorotational<LocalDilatation, Rotation, update>>(elements);
    return kernelsOf<PointCorotational<LocalDilatation, Rotation, update>>(elements);
  });
}

}  // namespace stroma::hexahedron
