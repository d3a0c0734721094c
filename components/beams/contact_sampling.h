// SPDX-License-Identifier: LGPL-2.1-or-later
// The chain of points that the contacts of pushed rods act on.
#pragma once
#include "components/beams/rod_sampling.h"

namespace stroma {

/// Number of edges of the chain: that of the contact model of the rod with the most edges.
int contactEdges(const std::vector<PushedRod>& rods);

/// Lengths of the points from the opening, descending from the last tip. The spacing of the points is that of the contact
/// model of the rod that they are on, which is the outermost one there; where a rod emerges from another there is a point at
/// the tip of the latter. Points that would be in the opening or behind it are left out.
std::vector<double> contactPlaces(const std::vector<PushedRod>& rods, const RodNodes& nodes);

}  // namespace stroma
