// SPDX-License-Identifier: LGPL-2.1-or-later
// Prisms, all but those methods that turn at each point.
#include "components/elasticity/prisms_and_pyramids.h"

namespace stroma {

std::unique_ptr<ElementKernels> PrismShape::polarKernels(const PointElementsOf<PrismShape>& elements) {
  using Models = elastic::PointModels<PrismShape>;
  if (elements.variant.method == ElasticMethod::svd) return kernelsOf<Models::OneRotation<rotation::Svd>>(elements);
  return kernelsOf<Models::OneRotation<rotation::Polar>>(elements);
}

std::unique_ptr<ElasticElements> makePrisms() { return std::make_unique<PointCells<PrismShape>>(); }

}  // namespace stroma
