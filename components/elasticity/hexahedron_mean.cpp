// SPDX-License-Identifier: LGPL-2.1-or-later
// Hexahedra of any shape with dilatation = mean.
#include "components/elasticity/hexahedron_kernels.h"

#define STROMA_MEAN_FORCES
#include "components/elasticity/hexahedron_mean_forces.h"

namespace stroma::hexahedron {

std::unique_ptr<ElementKernels> meanKernels(const Elements& elements) {
  const ElasticVariant& variant = elements.shapes.variant();
  if (variant.method == ElasticMethod::small) return kernelsOf<PointLinear<MeanDilatation>>(elements);
  if (variant.exact_tangent) return exactMeanKernels(elements);
  return makeRotated(variant, [&]<class Rotation>() {
    return makeUpdated(variant, [&]<Update update>() {
      return kernelsOf<PointCorotational<MeanDilatation, Rotation, update>>(elements);
    });
  });
}

}  // namespace stroma::hexahedron
