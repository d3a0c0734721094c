// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <cmath>

#include "framework/algebra/block_matrix.h"

namespace stroma {

/// Of a Cholesky factor: its numbers, and the operations that make it.
struct FactorCounts {
  double entries = 0, flops = 0;
};
inline FactorCounts fewer(const FactorCounts& a, const FactorCounts& b) { return a.entries < b.entries ? a : b; }

/// Of a matrix with this pattern, counted for a minimum degree order. Up to a tenth more than in the best of several orders for
/// bodies of less than 10,000 nodes, and more for larger ones. Takes some milliseconds for 10,000 nodes.
FactorCounts countFactors(const BlockMatrix& pattern);
/// Whether a direct solver orders such a matrix by nested dissection too, which takes ten times as long: where ten factorisations
/// in a minimum degree order would take longer than that.
inline bool isDissected(double blocks, const FactorCounts& counts) { return counts.flops > 20e3 * blocks; }
/// The same in the better of both orders: with more than 5e8 operations, by up to a half of these in bodies of 2,744 to 4,913 nodes.
inline FactorCounts dissected(double blocks, const FactorCounts& counts) {
  if (!isDissected(blocks, counts)) return counts;
  const double larger = std::max(1.0, counts.flops / 5e8);
  return {counts.entries * std::pow(larger, -0.1), counts.flops * std::pow(larger, -0.3)};
}

}  // namespace stroma
