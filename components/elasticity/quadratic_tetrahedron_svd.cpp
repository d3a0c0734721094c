// SPDX-License-Identifier: LGPL-2.1-or-later
// Quadratic tetrahedra with method = svd.
#include "components/elasticity/quadratic_tetrahedron_rotated.h"

template std::unique_ptr<stroma::ElementKernels> stroma::quadratic_tetrahedron::rotatedKernels<stroma::rotation::Svd>(
    const Elements& elements);
