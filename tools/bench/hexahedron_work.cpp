// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/bench/hexahedron_work.h"

namespace stroma::bench {
namespace {

constexpr double node_numbers = 8 * 4, vector_row = 4 * sizeof(double);

}  // namespace

Work hexahedronProductWork(HexahedronVariant variant, double nodes) {
  const HexahedronOperations& each = hexahedron_operations[std::size_t(variant)];
  return {node_numbers + each.product_bytes + (each.product_reads_position ? 4 : 3) * vector_row * nodes, each.product};
}

Work hexahedronForceWork(HexahedronVariant variant, double nodes) {
  const HexahedronOperations& each = hexahedron_operations[std::size_t(variant)];
  return {node_numbers + each.force_bytes + 3 * vector_row * nodes, each.force};
}

}  // namespace stroma::bench
