// SPDX-License-Identifier: LGPL-2.1-or-later
// Tetrahedra around a common edge as one element of the loop: a fan of K tetrahedra has K + 3 nodes, so that a node is
// read and its force added 1 + 3/K times a tetrahedron instead of four. Gathering and scattering are what a product
// costs: a lane holds a fan.
#pragma once
#include <array>
#include <vector>

#include "framework/mesh/mesh.h"

namespace stroma::tetrahedron {

constexpr int fan_size = 2;
constexpr int fan_nodes = fan_size + 3;

/// Nodes 0 and 1 are the ends of the common edge, the others the ring around it; tetrahedron i of the fan has the nodes
/// corner(i, .). Where the mesh gives a fan too few tetrahedra, element is -1 and the nodes repeat a tetrahedron.
struct Fan {
  std::array<Index, fan_nodes> nodes;
  std::array<Index, fan_size> element;
};
constexpr int corner(int tetrahedron, int a) { return a < 2 ? a : tetrahedron + a; }

/// Every tetrahedron in one fan, as few fans as a walk from the most enclosed ones finds; ordered as the cells are.
std::vector<Fan> gatherFans(const std::vector<Tetrahedron>& cells, std::size_t node_count);

}  // namespace stroma::tetrahedron
