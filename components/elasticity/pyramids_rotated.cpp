// SPDX-License-Identifier: LGPL-2.1-or-later
// Pyramids with method = large, polar or svd.
#include "components/elasticity/point_rotated.h"
#include "components/elasticity/prisms_and_pyramids.h"

namespace stroma {

using Elements = PointElementsOf<PyramidShape>;
template std::unique_ptr<ElementKernels> rotatedKernels<PyramidShape, rotation::Qr>(const Elements&);
template std::unique_ptr<ElementKernels> rotatedKernels<PyramidShape, rotation::Polar>(const Elements&);
template std::unique_ptr<ElementKernels> rotatedKernels<PyramidShape, rotation::Svd>(const Elements&);

}  // namespace stroma
