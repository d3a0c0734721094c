// SPDX-License-Identifier: LGPL-2.1-or-later
// Bodies that start in one another, pushed apart.
//
// A point p of a body that is inside of another one goes towards the closest point q of the other's surface, and q towards p, until
// they have changed sides and are a gap apart. With n = (q - p)/|q - p|, weights c_i of both in the nodes i, and w_i = 0 of what is
// held or an obstacle, else 1, node i goes by
//
//   u_i = w_i c_i n (|q - p| + gap) / sum_j w_j c_j^2
//
// the mean of these over all points that say something of it. p are vertices, and the middles of what lies inside of an edge whose
// ends are outside. What is nearer than the gap without being inside is pushed apart in the same way. Nodes of a body that nothing is
// said of follow their neighbours: u_i is the mean of u_j over the nodes j that share an edge of a cell with i, so that a free body is
// shifted, and one that is held bends. All of it is repeated until nothing is nearer than the gap.
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

/// Moves rows of x until surfaces are `gap` [m] apart, at least; project and independent: see PlacesStart. Returns the longest way of
/// a node [m]. Throws ComponentError where a cell would turn inside out. What could not be pushed apart stays in one another.
double pushApart(const BarrierLaw& law, const std::vector<StartBody>& bodies, double gap, Index independent,
                 const std::function<void(Rows)>& project, Rows x);

}  // namespace stroma::contact
