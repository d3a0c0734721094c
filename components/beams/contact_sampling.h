// SPDX-License-Identifier: LGPL-2.1-or-later
// The chain of points that contacts of pushed rods act on.
#pragma once
#include "components/beams/rod_sampling.h"

namespace stroma {

/// Edges of the chain: as many as the contact model of the rod that has most of them.
int contactEdges(const std::vector<PushedRod>& rods);

/// Lengths from the opening where points are, descending from the last tip on. Points follow one another as the contact model of the
/// rod that they are on has them, which is the outermost one there; where a rod comes out of another there is a point at the tip
/// of that one. Those that would be in the opening or behind it are left out.
std::vector<double> contactPlaces(const std::vector<PushedRod>& rods, const RodNodes& nodes);

}  // namespace stroma
