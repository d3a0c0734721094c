// SPDX-License-Identifier: LGPL-2.1-or-later
// Tetrahedra with method = polar.
#include "components/elasticity/tetrahedron_rotated.h"

template std::unique_ptr<stroma::ElementKernels> stroma::tetrahedron::rotatedKernels<stroma::rotation::Polar>(
    const ElasticVariant& variant, const Elements& elements);
