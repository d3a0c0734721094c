// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/mesh/cell_kind.h"

namespace stroma {

/// A point in a cell of a volume.
struct PlaceInCell {
  std::array<double, most_cell_nodes> weights{};  ///< N_a, one per node; of a point outside, continued linearly from the nearest side
  double distance = 0;                            ///< how far outside [m]
  LocalPoint xi{};                                ///< in the reference cell; of a point outside, on its border
};

/// Solves x(xi) = p by Newton's method held in the reference cell. Outside it ends at the side that the point lies beyond; an affine
/// field stays exact there. `corners`: shape (nodes of the kind). A flat cell gives a distance that is no number.
PlaceInCell placeInCell(const CellKind& kind, const Vec3* corners, const Vec3& p);

}  // namespace stroma
