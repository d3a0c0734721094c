// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "framework/scene/types.h"

namespace stroma::amg {

/// Which nodes of a level hold each other strongly: rows of neighbours, without the node itself.
struct StrongGraph {
  std::vector<Index> start{0}, neighbours;  ///< shape (nodes + 1), (strong links)
  Index nodes() const { return Index(start.size()) - 1; }
};

/// The nodes of a level in groups, each of which becomes a node of the next one.
struct Aggregates {
  std::vector<Index> of;              ///< shape (nodes): the group; -1: none, the smoother alone serves the node
  std::vector<Index> start, members;  ///< the nodes of each group, ascending; shape (count + 1), (grouped nodes)
  Index count() const { return Index(start.size()) - 1; }
};

/// Vanek, Mandel, Brezina 1996: nodes none of whose strong neighbours is in a group make one with them; others join the
/// group that they have most links to; what then remains makes groups of its own. A node without a strong neighbour is
/// in none. Nodes with no fewer neighbours than the mean come first: of a cube cut into five tetrahedra per cell, nodes have
/// 18 neighbours or 6, and groups around the former make a next level with a third of the numbers.
Aggregates aggregate(const StrongGraph& graph);

}  // namespace stroma::amg
