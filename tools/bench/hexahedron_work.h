// SPDX-License-Identifier: LGPL-2.1-or-later
// What the kernels of hexahedra cannot do without, an element: bytes by the layout of
// components/elasticity/hexahedron_points.h, flops counted by running the models' own mathematics on a number that counts.
#pragma once
#include <string>

#include "tools/bench/figure.h"

namespace stroma::bench {

/// The variants of HexahedronFEMForceField that are measured.
enum class HexahedronVariant { polar_boxes, polar_b, green };

Work hexahedronProductWork(HexahedronVariant variant, double nodes_per_element);
Work hexahedronForceWork(HexahedronVariant variant, double nodes_per_element);

}  // namespace stroma::bench
