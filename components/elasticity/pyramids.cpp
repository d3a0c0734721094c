// SPDX-License-Identifier: LGPL-2.1-or-later
// Pyramids, all but those methods that turn at each point.
#include "components/elasticity/prisms_and_pyramids.h"

namespace stroma {

std::unique_ptr<ElementKernels> PyramidShape::polarKernels(const PointElementsOf<PyramidShape>& elements) {
  using Models = elastic::PointModels<PyramidShape>;
  if (elements.variant.method == ElasticMethod::svd) return kernelsOf<Models::OneRotation<rotation::Svd>>(elements);
  return kernelsOf<Models::OneRotation<rotation::Polar>>(elements);
}

std::unique_ptr<ElasticElements> makePyramids() { return std::make_unique<PointCells<PyramidShape>>(); }

}  // namespace stroma
