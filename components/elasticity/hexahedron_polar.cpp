// SPDX-License-Identifier: LGPL-2.1-or-later
// Hexahedra with method = polar.
#include "components/elasticity/hexahedron_rotated.h"

template std::unique_ptr<stroma::ElementKernels> stroma::hexahedron::rotatedKernels<stroma::rotation::Polar>(
    const Elements& elements);
