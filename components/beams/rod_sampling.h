// SPDX-License-Identifier: LGPL-2.1-or-later
// Placement of the nodes of rods that are pushed through one opening, one inside the other. Lengths are measured from the
// opening [m].
#pragma once
#include <vector>

#include "components/beams/rod_shape.h"

namespace stroma {

/// A rod whose tip is `tip` beyond the opening; its handle is at tip - length, which is usually behind the opening.
struct PushedRod {
  const RodShape* shape = nullptr;
  double tip = 0;
  double handle() const { return tip - shape->length(); }
  /// Whether the rod is present at a length, within `slack`.
  bool isAt(double at, double slack) const { return at >= handle() - slack && at <= tip + slack; }
};

/// Ascending from the opening to the last tip, with the rods present at each node and whether it lies on a rigid stretch.
struct RodNodes {
  std::vector<double> at;
  std::vector<std::vector<int>> rods;
  std::vector<bool> is_held;
};

/// Nodes nearer to each other than `threshold` are one. `rigid` has the ends of stretches that are held, two by two; there are nodes
/// there, and by `step` before and behind.
struct RodSampling {
  double threshold = 0;
  std::vector<double> rigid = {};
  double step = 0;
};

/// At key points that are out, and between them where a stretch has its beams: those of the first rod, and of the next ones where no
/// former one has a stretch; more where a helix would turn by half a turn. Of nodes nearer to each other than `threshold` one is left,
/// the opening or a tip where one of these is among them. Without a rod that is out: one node.
RodNodes sampleRods(const std::vector<PushedRod>& rods, const RodSampling& sampling);

/// The tip positions at which the rods need the most nodes, and that number.
struct MostNodes {
  std::size_t nodes = 0;
  std::vector<double> tips;
};
/// While one rod advances until all of it is out.
MostNodes mostNodesOnWay(std::vector<PushedRod> rods, std::size_t moving, const RodSampling& sampling);
/// Over all positions of the tips, 13 for each.
MostNodes mostNodesAnywhere(std::vector<PushedRod> rods, const RodSampling& sampling);

/// For each node the length where it was before the last tip went on by `moved`: nodes from the last tip back to where
/// there is more than one rod, or a rigid stretch, came along, the others, and the opening, stayed.
std::vector<double> formerPlaces(const RodNodes& now, double moved);

/// A frame on the cubic curve between two frames, at the fraction s of its length: x along the curve, with the rotation about
/// it interpolated.
Placement between(const Placement& a, const Placement& b, double length, double s);

}  // namespace stroma
