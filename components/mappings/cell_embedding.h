// SPDX-License-Identifier: LGPL-2.1-or-later
// Points in the cells of a body: each in the cell that holds it, or in the nearest one.
#pragma once
#include <limits>
#include <vector>

#include "framework/mesh/topology.h"

namespace stroma {

/// Where a point lies best.
struct EmbeddedPoint {
  double distance = std::numeric_limits<double>::infinity();  ///< out of its cell [m]; infinite: no cell can hold it
  std::vector<Index> nodes;                                   ///< of the cell
  std::vector<double> weights;                                ///< N_a, one per node
  std::vector<Vec3> slopes;  ///< the gradients of N_a [1/m], one per node; none in a cell without a volume
};

/// Of each point the place in the cells of the largest dimension, whose nodes lie at `body`. `size` becomes the diagonal of the
/// box of all cells [m]. Throws ComponentError where there are no cells.
std::vector<EmbeddedPoint> embedPoints(const Topology& topology, const std::vector<Vec3>& body, const std::vector<Vec3>& points,
                                       double& size);

}  // namespace stroma
