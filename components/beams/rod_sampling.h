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

/// Ascending from the opening to the last tip, which rods are at each, and whether it lies on a rigid stretch.
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

/// Where tips are when rods need most nodes, and how many.
struct MostNodes {
  std::size_t nodes = 0;
  std::vector<double> tips;
};
/// As one rod goes on until all of it is out.
MostNodes mostNodesOnWay(std::vector<PushedRod> rods, std::size_t moving, const RodSampling& sampling);
/// Wherever tips may come to, of 13 places each.
MostNodes mostNodesAnywhere(std::vector<PushedRod> rods, const RodSampling& sampling);

/// For each node the length where it was before the last tip went on by `moved`: nodes from the last tip back to where
/// there is more than one rod, or a rigid stretch, came along, the others, and the opening, stayed.
std::vector<double> formerPlaces(const RodNodes& now, double moved);

/// A frame on the cubic curve between two, at the part s of its length: x along the curve, turned about it between both.
Placement between(const Placement& a, const Placement& b, double length, double s);

}  // namespace stroma
