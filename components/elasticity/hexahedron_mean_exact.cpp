// SPDX-License-Identifier: LGPL-2.1-or-later
// Hexahedra of any shape with dilatation = mean and tangent = exact.
#include "components/elasticity/hexahedron_kernels.h"

// Their forces are those of hexahedron_mean.cpp.
#define STROMA_MEAN_FORCES extern
#include "components/elasticity/hexahedron_mean_forces.h"

namespace stroma::hexahedron {

std::unique_ptr<ElementKernels> exactMeanKernels(const Elements& elements) {
  const ElasticVariant& variant = elements.shapes.variant();
  return makeRotated(variant, [&]<class Rotation>() {
    return makeUpdated(variant, [&]<Update update>() {
      return kernelsOf<ExactPointCorotational<MeanDilatation, Rotation, update>>(elements);
    });
  });
}

}  // namespace stroma::hexahedron
