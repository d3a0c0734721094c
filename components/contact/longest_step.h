// SPDX-License-Identifier: LGPL-2.1-or-later
// How far the points of a pair may move, x + t dx, before they touch. After the additive continuous collision detection
// of Li, Kaufman and Jiang 2021: with the pair at distance d at time t, two advances are safe,
//   0.9 d / (largest |v| of one side + largest |v| of the other),   v = dx less its mean,
//   and as long as the direction n of the distance separates the sides: min n.x of one > max n.x of the other,
// and the larger one is taken, until the pair is nearer than `left` times its initial distance. The second one does not
// shrink for points that slide along each other. No root is searched, so none is missed: the result is certainly free of contact, and
// a t < longest means that the pair comes nearer than that.
#pragma once
#include "framework/collision/pair_distances.h"

namespace stroma {

struct StepOptions {
  double longest = 1;
  double thickness = 0;  ///< distance at which surfaces touch [m]
  double left = 0.1;     ///< fraction of the initial distance at which the step ends. Small: pairs that do not touch pass
};

/// The t in [0, longest] up to which the pair may move. 0 if it touches at the start, to 1e-12 of its size and to the round-off of
/// its coordinates, even without motion. At the returned t at least a hundredth of `left` times the initial distance remains, so the
/// rounded positions x + t dx do not touch either. After 1000 advances it returns the t reached.
double longestStep(PairKind kind, const FourPoints& x, const FourPoints& dx, const StepOptions& options = {});

/// A point at distance `gap` from a plane, with closing speed `closing`.
double longestStepToPlane(double gap, double closing, const StepOptions& options = {});

}  // namespace stroma
