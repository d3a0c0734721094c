// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/contact/kept_gaps.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace stroma::contact {

bool KeptGap::isOfParallelEdges(const BarrierLaw& law, const std::vector<Vec3>& x) const {
  constexpr double least = 1e-3;
  if (!pair || pair->kind != PairKind::edge_edge) return false;
  const FourPoints p = law.candidates.pointsOf(*pair, x);
  const Vec3 a = p[1] - p[0], b = p[3] - p[2];
  return a.cross(b).squaredNorm() <= least * a.squaredNorm() * b.squaredNorm();
}

void KeptGap::look(const BarrierLaw& law, const std::vector<Vec3>& x) {
  if (!pair) {
    c[0] = 1;
    n = law.planes[plane].normal;
    gap = law.gapToPlane(plane, x[std::size_t(v[0])]) - law.range;
  } else {
    const ClosestPoints closest = closestPoints(pair->kind, law.candidates.pointsOf(*pair, x));
    const double apart = closest.distance();
    c = closest.weights;
    n = apart > 0 ? Vec3(closest.difference / apart) : side;
    gap = apart - pair->radius - law.thickness - law.range;
    // passed through, or so deep that its direction tells nothing: back to the plane that was between them
    const bool is_deep = apart < 0.5 * (pair->radius + law.thickness + law.range);
    if (n.dot(side) < 0 || (is_deep && !side.isZero(0))) {
      c = side_c, n = side;
      double height = 0;
      for (std::size_t k = 0; k < 4; ++k) height += c[k] * n.dot(x[std::size_t(v[k])]);
      gap += height - apart;
    }
  }
  tangent = across - n * n.dot(across);
  if (const double length = tangent.norm(); length > 0) tangent /= length;
}

void ignoreDoubles(std::vector<KeptGap>& gaps, std::vector<GapKey>& keys) {
  keys.clear();
  for (std::size_t i = 0; i < gaps.size(); ++i) {
    const KeptGap& gap = gaps[i];
    if (!gap.pair) continue;
    std::array<int, 4> key{-1, -1, -1, -1};
    for (std::size_t k = 0; k < 4; ++k)
      if (gap.c[k] != 0) key[k] = gap.v[k];
    std::sort(key.begin(), key.end());
    keys.push_back({key, i});
  }
  std::sort(keys.begin(), keys.end());
  for (std::size_t k = 1; k < keys.size(); ++k)
    if (keys[k].vertices == keys[k - 1].vertices) gaps[keys[k].gap].counts = false;
}

}  // namespace stroma::contact
