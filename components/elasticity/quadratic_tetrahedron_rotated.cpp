// SPDX-License-Identifier: LGPL-2.1-or-later
// Quadratic tetrahedra with method = large, polar or svd.
#include "components/elasticity/quadratic_tetrahedron_rotated.h"

namespace stroma::quadratic_tetrahedron {

template std::unique_ptr<ElementKernels> rotatedKernels<rotation::Qr>(const Elements&);
template std::unique_ptr<ElementKernels> rotatedKernels<rotation::Polar>(const Elements&);
template std::unique_ptr<ElementKernels> rotatedKernels<rotation::Svd>(const Elements&);

}  // namespace stroma::quadratic_tetrahedron
