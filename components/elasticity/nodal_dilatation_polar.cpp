// SPDX-License-Identifier: LGPL-2.1-or-later
// Tetrahedra with method = polar and dilatation = mean.
#include "components/elasticity/tetrahedron_rotated.h"

template std::unique_ptr<stroma::ElementKernels> stroma::tetrahedron::averagedKernels<stroma::rotation::Polar>(
    const ElasticVariant& variant, const Elements& elements);
