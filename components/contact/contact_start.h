// SPDX-License-Identifier: LGPL-2.1-or-later
// Separates bodies that overlap at the start.
//
// A point p of a body inside another one moves towards the closest point q of the other's surface, and q towards p, until they
// have passed each other and are a gap apart. With n = (q - p)/|q - p|, their weights c_i in the nodes i, and w_i = 0 for fixed
// nodes and obstacles, otherwise 1, node i moves by
//
//   u_i = w_i c_i n (|q - p| + gap) / sum_j w_j c_j^2
//
// averaged over all points that involve it. p are vertices, and midpoints of the inner segments of edges whose ends are outside.
// Pairs closer than the gap without overlap are separated in the same way. The other nodes of a body follow their neighbours:
// u_i is the mean of u_j over the nodes j that share a cell edge with i, so that a free body is translated and a fixed one
// deforms. This is repeated until nothing is closer than the gap.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "components/contact/contact_terms.h"

namespace stroma::contact {

struct StartBody {
  const State* state;
  const Mesh* mesh;
};

/// Moves rows of x until surfaces are at least `gap` [m] apart; project and independent: see CorrectsStart. Returns the largest
/// displacement of a node [m]. Throws ComponentError if a cell would be inverted. Bodies that cannot be separated still overlap afterwards.
double pushApart(const BarrierLaw& law, const std::vector<StartBody>& bodies, double gap, Index independent,
                 const std::function<void(Rows)>& project, Rows x);

}  // namespace stroma::contact
