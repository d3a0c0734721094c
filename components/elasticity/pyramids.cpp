// SPDX-License-Identifier: LGPL-2.1-or-later
// Pyramids, all but those methods that turn at each point.
#include "components/elasticity/prisms_and_pyramids.h"

namespace stroma {

std::unique_ptr<ElementKernels> PyramidShape::polarKernels(const PointElementsOf<PyramidShape>& elements) {
  return kernelsOfOneRotation(elements);
}

std::unique_ptr<ElasticElements> makePyramids() { return std::make_unique<PointCells<PyramidShape>>(); }

}  // namespace stroma
