// SPDX-License-Identifier: LGPL-2.1-or-later
// Where the nodes of rods lie that are pushed through one opening, one in the other. Lengths are those from the opening on [m].
#pragma once
#include <vector>

#include "components/beams/rod_shape.h"

namespace stroma {

/// A rod whose tip is out by `tip`; its handle is at tip - length, which is mostly behind the opening.
struct PushedRod {
  const RodShape* shape = nullptr;
  double tip = 0;
  double handle() const { return tip - shape->length(); }
  /// Whether it is at a length, give or take `slack`.
  bool isAt(double at, double slack) const { return at >= handle() - slack && at <= tip + slack; }
};

/// Ascending from the opening to the last tip, and which rods are at each.
struct RodNodes {
  std::vector<double> at;
  std::vector<std::vector<int>> rods;
};

/// At key points that are out, and between them where a stretch has its beams: those of the first rod, and of the next ones where no
/// former one has a stretch; more where a helix would turn by half a turn. Of nodes nearer to each other than `threshold` one is left,
/// the opening or a tip where one of these is among them. Without a rod that is out: one node.
RodNodes sampleRods(const std::vector<PushedRod>& rods, double threshold);

/// For each node the length where it was before the last tip went on by `moved`: nodes from the last tip back to where
/// there is more than one rod came along, the others, and the opening, stayed.
std::vector<double> formerPlaces(const RodNodes& now, double moved);

/// A frame on the cubic curve between two, at the part s of its length: x along the curve, turned about it between both.
Placement between(const Placement& a, const Placement& b, double length, double s);

}  // namespace stroma
