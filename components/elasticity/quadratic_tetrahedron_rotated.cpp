// SPDX-License-Identifier: LGPL-2.1-or-later
// Quadratic tetrahedra with method = large, polar or svd.
#include "components/elasticity/point_rotated.h"
#include "components/elasticity/quadratic_tetrahedron_models.h"

namespace stroma {

using Elements = PointElementsOf<quadratic_tetrahedron::Shape>;
template std::unique_ptr<ElementKernels> rotatedKernels<quadratic_tetrahedron::Shape, rotation::Qr>(const Elements&);
template std::unique_ptr<ElementKernels> rotatedKernels<quadratic_tetrahedron::Shape, rotation::Polar>(const Elements&);
template std::unique_ptr<ElementKernels> rotatedKernels<quadratic_tetrahedron::Shape, rotation::Svd>(const Elements&);

}  // namespace stroma
