// SPDX-License-Identifier: LGPL-2.1-or-later
// The kernels of one rotation, for the source that instantiates them.
#pragma once
#include "components/elasticity/nodal_dilatation.h"

namespace stroma::tetrahedron {

template <class Rotation>
std::unique_ptr<ElementKernels> rotatedKernels(const ElasticVariant& variant, const Elements& elements) {
  return makeUpdated(variant, [&]<Update update>() {
    return variant.exact_tangent ? kernelsOf<ExactCorotational<Rotation, update>>(elements)
                                 : kernelsOf<Corotational<Rotation, update>>(elements);
  });
}
template <class Rotation>
std::unique_ptr<ElementKernels> averagedKernels(const ElasticVariant& variant, const Elements& elements) {
  return makeUpdated(variant, [&]<Update update>() {
    return variant.exact_tangent ? averagedKernelsOf<ExactDeviatoric<Rotation, update>>(elements)
                                 : averagedKernelsOf<Deviatoric<Corotational<Rotation, update>>>(elements);
  });
}

}  // namespace stroma::tetrahedron
