// SPDX-License-Identifier: LGPL-2.1-or-later
// Prisms, all but those methods that turn at each point.
#include "components/elasticity/prisms_and_pyramids.h"

namespace stroma {

std::unique_ptr<ElementKernels> PrismShape::polarKernels(const PointElementsOf<PrismShape>& elements) {
  return kernelsOfOneRotation(elements);
}

std::unique_ptr<ElementKernels> ReducedPrismShape::polarKernels(const PointElementsOf<ReducedPrismShape>& elements) {
  return kernelsOfOneRotation(elements);
}

std::unique_ptr<ElasticElements> makeReducedPrisms() { return std::make_unique<PointCells<ReducedPrismShape>>(); }
std::unique_ptr<ElasticElements> makePrisms() { return std::make_unique<PointCells<PrismShape>>(); }

}  // namespace stroma
