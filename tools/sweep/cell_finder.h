// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <utility>
#include <vector>

#include "framework/collision/box_tree.h"
#include "framework/mesh/cell_kind.h"
#include "tools/sweep/end_state.h"

namespace stroma::sweep {

/// A point in the rest shape of a body: the corners of the cell that holds it and their shape functions.
struct Place {
  std::array<Index, most_cell_nodes> nodes{};
  std::array<double, most_cell_nodes> weights{};
  int corners = 0;
  double distance = 0;  ///< how far outside of all cells [m]

  /// sum_a N_a value_a, shape of `values`: (nodes of the body).
  Vec3 of(const std::vector<Vec3>& values) const;
};

/// Finds cells of a body by boxes around them. A point outside belongs to the nearest cell, whose map is continued
/// linearly: an affine field stays exact.
class CellFinder {
 public:
  explicit CellFinder(const Body& body);
  Place find(const Vec3& point) const;

 private:
  const Body* body_;
  BoxTree tree_;  ///< of tetrahedra, then hexahedra
};

}  // namespace stroma::sweep
