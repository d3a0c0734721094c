// SPDX-License-Identifier: LGPL-2.1-or-later
// The proof of a step (kept_gaps.h): which pairs are watched, and whether their ways are free.
//
// Pairs of rigid bodies are searched as far as these two may move, w_a + w_b, so that a fast body costs no pairs of slow ones. Where
// two of them turn out to move farther against each other, the pairs between that and twice their motion are watched as well.
// No side of a pair moves farther than the box around the displacements of its body: most pairs need no other test.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "components/contact/kept_gaps.h"

namespace stroma::contact {

void KeptGaps::findPairs(const BarrierLaw& law, const std::vector<Vec3>& x, const std::vector<double>& ways) {
  ways_ = ways, extended_.clear(), extended_pairs_.clear();
  double most = way_;
  for (const double each : ways) most = std::max(most, each);
  is_searched_ = !law.candidates.areFarther(x, law.candidates.reach + 2 * most);
  if (!is_searched_)
    std::ranges::fill(ways_, most);  // all of them are that far apart
  else
    law.candidates.findWithin(x, [&](int a, int b) { return searchedDistance(a, b) / 2; });
}

/// How far two bodies may move against each other without meeting in a pair that nobody looks at [m].
double KeptGaps::searchedDistance(int a, int b) const {
  if (a == b || !rigid_[std::size_t(a)] || !rigid_[std::size_t(b)]) return 2 * way_;
  for (const ExtendedWatch& each : extended_)
    if (each.a == std::min(a, b) && each.b == std::max(a, b)) return each.way;
  return ways_[std::size_t(a)] + ways_[std::size_t(b)];
}

/// Watches the pairs of two rigid bodies that have come farther than they were looked for.
void KeptGaps::extendWatch(const BarrierLaw& law, int a, int b, double way) {
  const double before = searchedDistance(a, b), now = 2 * way, reach = law.candidates.reach;
  const std::size_t known = extended_pairs_.size();
  law.candidates.addFarther(a, b, start_, reach + before, reach + now, extended_pairs_);
  for (std::size_t i = known; i < extended_pairs_.size(); ++i) watch(extended_pairs_[i], law);
  std::erase_if(extended_, [&](const ExtendedWatch& each) { return each.a == std::min(a, b) && each.b == std::max(a, b); });
  extended_.push_back({std::min(a, b), std::max(a, b), now});
}

void KeptGaps::watch(const Candidate& pair, const BarrierLaw& law) {
  const Surfaces& s = law.surfaces;
  watched_.push_back({&pair, pair.distance - (pair.pushes ? law.thickness : 0), s.bodyOf(pair.v[0]), s.bodyOf(pair.v[3])});
}

/// Of bodies a and b, from the boxes around their displacements [m].
double KeptGaps::boundOfRelativeMotion(int a, int b) {
  if (!are_boxes_known_) return std::numeric_limits<double>::infinity();
  if (a != of_pair_[0] || b != of_pair_[1])
    of_pair_ = {a, b}, most_of_pair_ = boundOfDifference(around_[std::size_t(a)], around_[std::size_t(b)]);
  return most_of_pair_;
}

PathCheck KeptGaps::checkPathOf(const BarrierLaw& law, const Candidate& pair, double start, const std::vector<Vec3>& x) const {
  const FourPoints places = law.candidates.pointsOf(pair, start_);
  FourPoints ways = law.candidates.pointsOf(pair, x);
  for (std::size_t k = 0; k < 4; ++k) ways[k] -= places[k];
  return checkPath(law, pair, start, places, ways);
}

/// Makes touches_ those of the straight ways, less what rigid bodies go around as they turn, and what follows from them.
void KeptGaps::findFirstTouches(const BarrierLaw& law, const std::vector<Vec3>& x) {
  touches_.clear(), unexpected_.clear(), not_free_ = nullptr;
  if (all_.empty() && watched_.empty()) return;
  const Surfaces& s = law.surfaces;
  const auto touch = [&](const Candidate& pair, double free, KeptGap* gap) {
    const auto [a, b] = std::minmax({s.bodyOf(pair.v[0]), s.bodyOf(pair.v[3])});
    touches_.push_back({&pair, free, gap, isOfRigid(a, b), a, b});
  };
  for (KeptGap& gap : all_) {
    gap.free = 1;
    if (!gap.pair) continue;
    const double most = boundOfRelativeMotion(s.bodyOf(gap.v[0]), s.bodyOf(gap.v[3]));
    if (gap.staysFar(law, most)) {
      gap.moved = most;
      continue;
    }
    const PathCheck way = checkPathOf(law, *gap.pair, gap.start, x);
    gap.moved = way.moved, gap.free = way.free;
    if (gap.free < 1) touch(*gap.pair, gap.free, &gap);
  }
  for (const Watched& each : watched_) {
    const double most = boundOfRelativeMotion(each.a, each.b);
    if (each.start > 0 && most < certainly_free * each.start && each.start - most > law.range) continue;
    const PathCheck way = checkPathOf(law, *each.pair, each.start, x);
    if (way.free < 1) touch(*each.pair, way.free, nullptr);
    const bool may_be_near = isOfRigid(each.a, each.b) && each.pair->pushes && each.start - way.moved < law.range;
    if (way.free < 1 || !may_be_near) continue;
    const double apart = leastDistance(each.pair->kind, law.candidates.pointsOf(*each.pair, x)) - each.pair->radius - law.thickness;
    if (apart < law.range) unexpected_.push_back(each.pair);
  }
  if (touches_.empty()) return;
  removeTouchesOfRotations(law, x);
  first_.assign(x.size(), untouched);
  double least = untouched;
  for (const Touch& each : touches_) {
    unproved_ = std::max(unproved_, law.range);
    if (!each.gap && each.is_rigid && each.pair->pushes) unexpected_.push_back(each.pair);
    if (each.free < least) least = each.free, not_free_ = each.pair;
    for (int k = 0; k < passing(*each.pair); ++k) {
      double& first = first_[std::size_t(each.pair->v[std::size_t(k)])];
      first = std::min(first, each.free);
    }
  }
}

/// For what comes near and was not expected to.
void KeptGaps::addSpareConditions() {
  constexpr std::size_t some = 32, part = 4;
  next_spare_ = all_.size();
  if (std::ranges::count_if(rigid_, [](char each) { return each != 0; }) < 2) return;
  KeptGap spare;
  spare.is_spare = spare.is_lower_bound = spare.is_rigid = true, spare.gap = way_;
  all_.insert(all_.end(), some + next_spare_ / part, spare);
  has_spares_ = true;
}

/// Watched pairs that have come near become conditions. Without a condition the step is not proved.
void KeptGaps::makeConditions(const BarrierLaw& law, const std::vector<Vec3>& x) {
  if (unexpected_.empty()) return;
  std::ranges::sort(unexpected_, [](const Candidate* a, const Candidate* b) { return *a < *b; });
  const std::size_t first = next_spare_;
  for (const Candidate* pair : unexpected_) {
    if (next_spare_ >= all_.size()) {
      unproved_ = std::max(unproved_, law.range);
      if (!not_free_) not_free_ = pair;
      break;
    }
    KeptGap& gap = all_[next_spare_++];
    makeGap(*pair, true, law, gap);
    gap.moved = checkPathOf(law, *pair, gap.start, x).moved;
  }
  for (Touch& each : touches_)
    for (std::size_t i = first; i < next_spare_; ++i)
      if (all_[i].pair == each.pair) all_[i].free = each.free, each.gap = &all_[i];
  std::erase_if(watched_, [&](const Watched& each) {
    return std::any_of(all_.begin() + std::ptrdiff_t(first), all_.begin() + std::ptrdiff_t(next_spare_),
                       [&](const KeptGap& gap) { return gap.pair == each.pair; });
  });
}

/// Takes away touches of bodies that go around each other.
void KeptGaps::removeTouchesOfRotations(const BarrierLaw& law, const std::vector<Vec3>& x) {
  std::ranges::stable_sort(touches_, {}, [](const Touch& each) { return std::array{each.a, each.b}; });
  std::array<int, 2> last{-1, -1};
  bool are_free = false;
  std::erase_if(touches_, [&](const Touch& each) {
    if (!each.is_rigid) return false;
    if (const std::array now{each.a, each.b}; now != last)
      last = now, are_free = areFreeWhileRotating(law, each.a, each.b, x, false) || areFreeWhileRotating(law, each.a, each.b, x, true);
    if (are_free && each.gap) each.gap->free = 1;
    return are_free;
  });
}

/// It is the first that its vertices touch, or they touch nothing.
bool KeptGaps::isTrusted(const KeptGap& gap, const BarrierLaw& law, const std::vector<Vec3>& x) const {
  constexpr double together = 0.05;  // of the gap to keep, on the way from one to the other
  if (!not_free_) return true;
  double first = 1;
  for (int k = 0; k < gap.passing(); ++k) first = std::min(first, first_[std::size_t(gap.v[std::size_t(k)])]);
  if (gap.free == first) return true;
  FourPoints ways;
  for (std::size_t k = 0; k < 4; ++k) ways[k] = x[std::size_t(gap.v[k])] - start_[std::size_t(gap.v[k])];
  return gap.passing() == 0 || (gap.free - first) * contact::boundOfRelativeMotion(gap.pair->kind, ways) <= together * law.range;
}

/// Of two bodies that may meet, and of each that planes may meet with -1.
template <class Visit>
void KeptGaps::forEachMeeting(const BarrierLaw& law, Visit&& visit) const {
  const auto& bodies = law.surfaces.bodies();
  for (int a = 0; a < int(bodies.size()); ++a) {
    const bool moves = bodies[std::size_t(a)].moves;
    if (moves && !law.planes.empty()) visit(a, -1);
    for (int b = law.candidates.self_contact && moves ? a : a + 1; b < int(bodies.size()); ++b)
      if ((moves || bodies[std::size_t(b)].moves) && !law.surfaces.areExcluded(a, b)) visit(a, b);
  }
}

/// Makes around_ the boxes of all displacements. False: some are no numbers.
bool KeptGaps::boxDisplacements(const BarrierLaw& law, const std::vector<Vec3>& x) {
  const auto& bodies = law.surfaces.bodies();
  around_.resize(bodies.size());
  bool are_numbers = true;
  for (std::size_t b = 0; b < bodies.size(); ++b)
    if (const std::size_t first = std::size_t(bodies[b].first_vertex), count = std::size_t(bodies[b].vertices); count > 0)
      are_numbers = boxAround(x.data() + first, start_.data() + first, count, around_[b]) && are_numbers;
  of_pair_ = {-1, -1};
  return are_numbers;
}

/// Boxes around displacements say that nothing has moved farther than pairs were looked for, or these are looked for now.
bool KeptGaps::isWithin(const BarrierLaw& law, const std::vector<Vec3>& x) {
  are_boxes_known_ = boxDisplacements(law, x);
  if (!are_boxes_known_) return false;
  Box of_planes;
  of_planes.add(Vec3(law.moved - moved_at_start_));
  bool is_within = true;
  forEachMeeting(law, [&](int a, int b) {
    const double most = boundOfDifference(around_[std::size_t(a)], b < 0 ? of_planes : around_[std::size_t(b)]);
    if (b >= 0 && isOfRigid(a, b)) {
      if (!(most > ways_[std::size_t(a)] + ways_[std::size_t(b)] && most > searchedDistance(a, b))) return;
      if (canExtendWatch())
        extendWatch(law, a, b, most);
      else
        is_within = false;
    } else {
      is_within = is_within && most <= 2 * way_;
    }
  });
  return is_within;
}

/// By how much something has moved farther than pairs were looked for.
double KeptGaps::beyond(const BarrierLaw& law, const std::vector<Vec3>& x) {
  if (isWithin(law, x)) return 0;
  all_moved_.set(x, &start_);
  for (std::size_t b = 0; b < bodies_.size(); ++b) moved_[b] = displacementsOf(bodies_[b], all_moved_, {});
  Displacements of_planes;
  of_planes.box.add(Vec3(law.moved - moved_at_start_));
  of_planes.longest = (law.moved - moved_at_start_).norm();
  double most = 0;  // above what pairs were searched for
  forEachMeeting(law, [&](int a, int b) {
    const bool is_rigid = b >= 0 && isOfRigid(a, b);
    if (are_boxes_known_ && is_rigid && canExtendWatch()) return;
    const double motion = boundOfDifference(moved_[std::size_t(a)], b < 0 ? of_planes : moved_[std::size_t(b)]);
    const bool is_above = are_boxes_known_ && b < 0 && rigid_[std::size_t(a)] && motion > 2 * way_ && isAbovePlanes(law, a, x);
    if (!is_above) most = std::max(most, motion - (is_rigid ? searchedDistance(a, b) : 2 * way_));
  });
  return most;
}

/// The vertices of a body that were too far from a plane for a condition keep the gap as well: the way between is free then.
bool KeptGaps::isAbovePlanes(const BarrierLaw& law, int body, const std::vector<Vec3>& x) const {
  for (const int v : bodies_[std::size_t(body)].vertices)
    for (std::size_t p = 0; p < law.planes.size(); ++p) {
      const Vec3 &plane = law.planes[p].normal, before = start_[std::size_t(v)] + (law.moved - moved_at_start_);
      const double now = law.gapToPlane(p, std::size_t(v), x[std::size_t(v)]), start = now - plane.dot(x[std::size_t(v)] - before);
      if (start >= law.range + 2 * way_ && now < law.range) return false;
    }
  return true;
}

}  // namespace stroma::contact
