// SPDX-License-Identifier: LGPL-2.1-or-later
// Searches through all pairs of the parts of surfaces, and pairs that are led through each other: hundreds of thousands of them, so
// that their source is compiled with optimisation.
#pragma once
#include <random>
#include <set>
#include <tuple>
#include <vector>

#include "components/contact/contact_surfaces.h"
#include "framework/collision/pair_distances.h"

namespace stroma::test {

using Key = std::tuple<PairKind, int, int>;

/// The pairs of two sides that share no vertex and are nearer than `reach`, less their radii; obstacles do not meet each other.
std::vector<Key> pairsNearerThan(double reach, const contact::Surfaces& s, const std::vector<Vec3>& x);

/// All edges and triangles that cross at x, by asking each two of them.
std::set<std::pair<int, int>> allCrossings(const contact::Surfaces& s, const std::vector<Vec3>& x);

/// Steps that every pair lets be, each asked alone, if it is brought no nearer than a tenth of its distance, to a millionth of that:
/// a shorter one, and a longer one, where a pair may be left out that stays farther apart than a tenth of the reach.
struct StepsOfAll {
  double shorter = 1, longer = 1;
};
StepsOfAll stepsOfAllPairs(const contact::Surfaces& s, const std::vector<Vec3>& x, const std::vector<Vec3>& way, double reach);

class Motions {
 public:
  explicit Motions(unsigned seed) : random_(seed) {}
  double number(double low = -1, double high = 1);
  Vec3 point();
  FourPoints four();
  /// Pairs of which a point of each side is at one place at time `when`. `degenerate`: slivers, parallel edges, points at corners, ...
  void meeting(PairKind kind, double when, int degenerate, double scale, FourPoints& x, FourPoints& dx);

 private:
  std::mt19937 random_;
};

/// Of 200 instants up to `until`.
double smallestDistance(PairKind kind, const FourPoints& x, const FourPoints& dx, double until);

}  // namespace stroma::test
