// SPDX-License-Identifier: LGPL-2.1-or-later
// Outputs of kept gaps. A node's pressure is its normal force over its part of the surface that faces this force, as with forces from a
// law; its contact area is that part. A contact slides if its friction is the largest possible one and it has moved by more than round-off
// in the step.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "components/contact/contact_outputs.h"
#include "components/contact/kept_gaps.h"

namespace stroma::contact {
namespace {

constexpr double farthest = 2;  // of contactDistance, beyond which gaps of nodes are not evaluated

/// The gap at x, without contactDistance. Bounds, and gaps along directions of another place, are replaced.
double gapAt(const KeptGap& gap, const KeptGaps& gaps, const BarrierLaw& law, const std::vector<Vec3>& x, double least) {
  const bool is_of_other_place = gaps.keepsDirections() && gap.pair && gap.is_active;
  if (gap.is_aligned || !(gap.is_lower_bound || is_of_other_place) || (gap.is_lower_bound && gap.gap >= least)) return gap.gap;
  KeptGap there = gap;
  there.look(law, gaps.start(), x, true);
  return there.gap;
}

bool slides(const KeptGap& gap, const double* forces, std::size_t each, double mu, const Vec3& slid, double tolerated) {
  constexpr double all = 0.999, round_off = 1e-3;  // of what is tolerated: contacts that stick are held far better, and any speed counts
  if (each == 1) return true;
  return std::hypot(forces[1], forces[2]) >= all * mu * forces[0] && (slid - gap.n * gap.n.dot(slid)).norm() > round_off * tolerated;
}

}  // namespace

/// A step touches few of many nodes. False: they are not known.
bool Outputs::clearNoted(const Surfaces& s, const State& first, double far) {
  if (!std::exchange(knows_noted_, true) || gaps_.size() != std::size_t(first.size())) return noted_.clear(), false;
  for (const int v : noted_) {
    const std::size_t node = std::size_t(s.rows[std::size_t(v)] - first.firstRow());
    contact_forces_[node].setZero(), friction_forces_[node].setZero();
    pressures_[node] = areas_[node] = rubs_[node] = 0, gaps_[node] = far, states_[node] = 0;
  }
  return noted_.clear(), true;
}

int Outputs::note(const BarrierLaw& law, KeptGaps& gaps, std::span<const double> forces, std::size_t each, double mu, double tolerated,
                  const std::vector<Vec3>& x, const std::vector<State*>& bodies) {
  const Surfaces& s = law.surfaces;
  const State& first = *bodies.front();
  const double far = farthest * law.range;
  smallest_gap_ = gaps.all().empty() ? 0 : gaps.smallest(law, x) + law.range;
  if (!clearNoted(s, first, far)) clearNodes(std::size_t(first.size()), far);
  wrenches_.begin();
  int count = 0;
  for (std::size_t i = 0; i < gaps.all().size(); ++i) {
    const KeptGap& gap = gaps.all()[i];
    if (gap.is_spare) continue;
    const double* l = forces.data() + each * i;
    const bool pushes = l[0] > 0;
    const double distance = law.range + gapAt(gap, gaps, law, x, far - law.range);
    if (!pushes && distance >= far) continue;
    count += pushes;
    const Vec3 normal = pushes ? Vec3(l[0] * gap.n) : Vec3::Zero();
    const Vec3 rubbing = pushes && each == 3 ? Vec3(l[1] * gap.tangent + l[2] * gap.n.cross(gap.tangent)) : Vec3::Zero();
    if (pushes) wrenches_.add(s, gap.v, gap.c, x, normal + rubbing);
    const int state = pushes && slides(gap, l, each, mu, gaps.slide(gap, law, x), tolerated) ? 2 : 1;
    for (std::size_t k = 0; k < 4; ++k) {
      if (gap.v[k] < 0 || !s.moves(gap.v[k]) || s.bodyOf(gap.v[k]) != 0 || gap.c[k] == 0) continue;
      const std::size_t node = std::size_t(s.rows[std::size_t(gap.v[k])] - first.firstRow());
      if (gaps_[node] == far && states_[node] == 0) noted_.push_back(gap.v[k]);
      gaps_[node] = std::min(gaps_[node], distance);
      const double push = std::abs(gap.c[k]) * l[0];
      if (!pushes || !(push > 0)) continue;
      contact_forces_[node] += gap.c[k] * normal, friction_forces_[node] += gap.c[k] * rubbing, pressures_[node] += push;
      if (push > rubs_[node]) rubs_[node] = push, states_[node] = state;
    }
  }
  for (const int v : noted_) {
    const std::size_t node = std::size_t(s.rows[std::size_t(v)] - first.firstRow());
    findPressure(law, v, x, first);
    areas_[node] = pressures_[node] > 0 ? contact_forces_[node].norm() / pressures_[node] : 0;
  }
  return count;
}

}  // namespace stroma::contact
