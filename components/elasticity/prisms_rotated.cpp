// SPDX-License-Identifier: LGPL-2.1-or-later
// Prisms with method = large, polar or svd.
#include "components/elasticity/point_rotated.h"
#include "components/elasticity/prisms_and_pyramids.h"

namespace stroma {

using Elements = PointElementsOf<PrismShape>;
template std::unique_ptr<ElementKernels> rotatedKernels<PrismShape, rotation::Qr>(const Elements&);
template std::unique_ptr<ElementKernels> rotatedKernels<PrismShape, rotation::Polar>(const Elements&);
template std::unique_ptr<ElementKernels> rotatedKernels<PrismShape, rotation::Svd>(const Elements&);

}  // namespace stroma
