// SPDX-License-Identifier: LGPL-2.1-or-later
// What the kernels of hexahedra cannot do without, an element: bytes by the layout of
// components/elasticity/hexahedron_points.h, flops as element_operations.h has them.
#pragma once
#include "tools/bench/element_operations.h"
#include "tools/bench/figure.h"

namespace stroma::bench {

Work hexahedronProductWork(HexahedronVariant variant, double nodes_per_element);
Work hexahedronForceWork(HexahedronVariant variant, double nodes_per_element);

}  // namespace stroma::bench
