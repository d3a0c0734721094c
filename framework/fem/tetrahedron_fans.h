// SPDX-License-Identifier: LGPL-2.1-or-later
// Two tetrahedra that share a face as one element of the loop: five nodes are read and five forces added for the two
// instead of eight. Gathering and scattering are what a product costs: a lane holds a fan.
#pragma once
#include <array>
#include <vector>

#include "framework/mesh/mesh.h"

namespace stroma::tetrahedron {

constexpr int fan_size = 2;
constexpr int fan_nodes = fan_size + 3;

/// Nodes 0, 1 and 3 are the common face, 2 and 4 the nodes that face each other across it; tetrahedron i of the fan has
/// the nodes corner(i, .). A tetrahedron without a partner has element[1] = -1 and repeats its node 2 as node 4.
struct Fan {
  std::array<Index, fan_nodes> nodes;
  std::array<Index, fan_size> element;
};
constexpr int corner(int tetrahedron, int a) { return a < 2 ? a : tetrahedron + a; }

/// Every tetrahedron in one fan; ordered as the cells are. The pairs are a matching of neighbours across faces by Karp
/// and Sipser's rule (1981): a tetrahedron with a single free neighbour left takes it at once, as it would stay alone
/// otherwise; when there is none, the next in the order of the cells takes its free neighbour that has the fewest
/// others. Not always the largest matching, in time linear in the cells.
std::vector<Fan> gatherFans(const std::vector<Tetrahedron>& cells, std::size_t node_count);
/// The nodes of each fan.
std::vector<std::array<Index, fan_nodes>> nodesOf(const std::vector<Fan>& fans);

}  // namespace stroma::tetrahedron
