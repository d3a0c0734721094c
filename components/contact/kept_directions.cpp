// SPDX-License-Identifier: LGPL-2.1-or-later
// Directions that stay (KeptGaps::keepDirections()). Forces along those of each round's place turn with it, by the correction over the
// size of a body, and rounds of steps in which bodies go as far as they are long do not come to an end. Along directions that stay
// forces are found by a few rounds, because only gaps are those of the place.
//
// Where the pair has turned away from its direction, as a vertex that goes past an edge on the other side of it, the gap along the
// direction stands for its distance: else it would be open with a force and closed without one. It is never wider than the distance has
// been found to be. One that is closed on another side gets the mean of its directions, as one that goes to and fro between two sides.
#include "components/contact/kept_gaps.h"

namespace stroma::contact {

void KeptGaps::keepDirections() {
  keeps_directions_ = true, looks_ = 0;
  kept_.assign(all_.size(), {});
  for (std::size_t i = 0; i < all_.size(); ++i)
    if (all_[i].is_active) kept_[i].take(all_[i]);
}

void KeptGaps::Directions::take(const KeptGap& gap) {
  const Vec3 sum = times * n + gap.n;  // none where they are opposite, as on both sides of a face
  n = times > 0 && sum.norm() > 1e-6 ? Vec3(sum.normalized()) : gap.n;
  if (is_any) ++times;
  is_of_place = !is_any, is_any = true;
  c = gap.c, upright = gap.upright, flush = gap.flush, more = 0;
}

void KeptGaps::restoreDirections(const BarrierLaw& law, const std::vector<Vec3>& x) {
  constexpr double like = 0.9;  // a cosine
  constexpr int few = 6;        // where gaps of the place go to and fro as well
  ++looks_;
  for (std::size_t i = 0; i < all_.size(); ++i) {
    KeptGap& gap = all_[i];
    Directions& kept = kept_[i];
    const bool is_closed = gap.is_active && gap.gap < -tolerated_, is_like = kept.n.dot(gap.n) > like;
    if (gap.is_active && (!kept.is_any || (is_closed && !is_like))) kept.take(gap);
    if (!kept.is_any) continue;
    const bool was_of_place = kept.is_of_place, is_here = gap.is_trusted && gap.free == 1 && !gap.is_lower_bound && is_like;
    kept.is_of_place = was_of_place && is_here && looks_ < few;
    const double here = gap.gap;
    gap.c = kept.c, gap.n = kept.n, gap.upright = kept.upright, gap.flush = kept.flush;
    gap.is_lower_bound = false, gap.is_active = gap.has_closed = true;
    gap.turnTangent();
    if (kept.is_of_place || !gap.pair) continue;
    double apart = 0;
    for (std::size_t k = 1; k < 4; ++k) apart += gap.c[k] * gap.n.dot(x[std::size_t(gap.v[k])] - x[std::size_t(gap.v[0])]);
    gap.gap = gap.upright * apart - gap.pair->radius - law.thickness - law.range + kept.more;
    if ((is_closed && is_like) || (was_of_place && is_here)) kept.more += here - gap.gap, gap.gap = here;
  }
}

}  // namespace stroma::contact
