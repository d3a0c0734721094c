// SPDX-License-Identifier: LGPL-2.1-or-later
// How far the points of a pair may move, x + t dx, before they touch. After the additive continuous collision detection
// of Li, Kaufman and Jiang 2021: with the pair at distance d at time t, two advances are safe,
//   0.9 d / (largest |v| of one side + largest |v| of the other),   v = dx less its mean,
//   and as long as the direction n of the distance separates the sides: min n.x of one > max n.x of the other,
// and the larger one is made, until the pair is nearer than `left` times its first distance. The second one does not
// tire of points that slide along each other. No root is searched, so none is missed: what is returned is free of contact for certain, and
// a t < longest says that the pair comes nearer than that.
#pragma once
#include "framework/collision/pair_distances.h"

namespace stroma {

struct StepOptions {
  double longest = 1;
  double thickness = 0;  ///< touching is this distance [m]
  double left = 0.1;     ///< of the first distance: nearer than that ends the step. Small: what does not touch passes
};

/// The t in [0, longest] up to which the pair may move. 0 when it touches from the start, to 1e-12 of its size and to the round-off of
/// its coordinates, also where it stands. At the t that is returned at least a hundredth of `left` times the first distance remains, and
/// places x + t dx that are rounded have not met either. After 1000 advances it is what has been reached.
double longestStep(PairKind kind, const FourPoints& x, const FourPoints& dx, const StepOptions& options = {});

/// A point at distance `gap` from a plane that nears it at `closing` per unit of time.
double longestStepToPlane(double gap, double closing, const StepOptions& options = {});

}  // namespace stroma
