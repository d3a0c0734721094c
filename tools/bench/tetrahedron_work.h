// SPDX-License-Identifier: LGPL-2.1-or-later
// What the kernels of corotational tetrahedra cannot do without, an element: bytes by the layout of
// components/elasticity/tetrahedron_corotational.h, flops as element_operations.h has them.
#pragma once
#include <string>

#include "tools/bench/figure.h"

namespace stroma::bench {

/// Element method and variant, in the words of TetrahedronFEMForceField.
struct Variant {
  std::string method = "large";
  bool update_b = false, update_volume = false;
};

/// One element of each operation, its share of the nodes' vectors included; `nodes_per_element` is that share.
Work productWork(const Variant& variant, double nodes_per_element);
Work forceWork(const Variant& variant, double nodes_per_element);
Work forceAndProductWork(const Variant& variant, double nodes_per_element);
Work polarEnergyWork(double nodes_per_element);
/// Into a matrix with this many 3x3 blocks per element, which are cleared, read and written once.
Work assemblyWork(const Variant& variant, double blocks_per_element);
/// The vectors of one iteration of conjugate gradients, a node.
Work conjugateGradientWork();

}  // namespace stroma::bench
