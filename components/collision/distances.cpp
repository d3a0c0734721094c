// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/collision/distances.h"

#include <algorithm>
#include <limits>

#include "framework/collision/exact_intersection.h"
#include "framework/collision/pair_distances.h"

namespace stroma {

namespace {
double ofEdges(const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& s) {
  return closestPoints(PairKind::edge_edge, {p, q, r, s}).distance();
}
double ofPoint(const Vec3& p, std::span<const Vec3> b) {
  if (b.size() < 3) return ofEdges(p, p, b.front(), b.back());
  return closestPoints(PairKind::point_triangle, {p, b[0], b[1], b[2]}).distance();
}
}  // namespace

double distanceOf(std::span<const Vec3> a, std::span<const Vec3> b) {
  if (a.size() > b.size()) return distanceOf(b, a);
  if (a.size() == 1) return ofPoint(a[0], b);
  if (b.size() == 2) return ofEdges(a[0], a[1], b[0], b[1]);
  double best = std::numeric_limits<double>::infinity();
  for (const Vec3& p : a) best = std::min(best, ofPoint(p, b));
  if (a.size() == 3)
    for (const Vec3& q : b) best = std::min(best, ofPoint(q, a));
  for (std::size_t i = 0; i < (a.size() == 2 ? 1 : 3); ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      const Vec3 &p = a[i], &q = a[(i + 1) % a.size()], &r = b[j], &s = b[(j + 1) % 3];
      if (segmentMeetsTriangle(p, q, b[0], b[1], b[2]) ||
          (a.size() == 3 && segmentMeetsTriangle(r, s, a[0], a[1], a[2])))
        return 0;
      best = std::min(best, ofEdges(p, q, r, s));
    }
  return best;
}

}  // namespace stroma
