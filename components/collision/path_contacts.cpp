// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/collision/path_contacts.h"

#include <algorithm>

namespace stroma::collision {

double firstNear(PairKind kind, const FourPoints& x, const FourPoints& way, double distance) {
  constexpr int most = 1000;  // then it is as good as near
  constexpr double never = 2;
  const std::size_t first_side = kind == PairKind::point_triangle ? 1 : 2;
  const Vec3 mean = 0.25 * (way[0] + way[1] + way[2] + way[3]);
  double speeds[2] = {0, 0}, size = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    double& speed = speeds[i < first_side ? 0 : 1];
    speed = std::max(speed, (way[i] - mean).norm()), size = std::max(size, (x[i] - x[0]).norm());
  }
  const double speed = speeds[0] + speeds[1], enough = std::max(1e-3 * distance, 1e-6 * size);
  double t = 0;
  for (int advance = 0; advance < most; ++advance) {
    FourPoints now = x;
    for (std::size_t i = 0; i < 4; ++i) now[i] += t * way[i];
    const double left = closestPoints(kind, now).distance() - distance;
    if (left <= enough) return t;
    if (!(left < (1 - t) * speed)) return never;
    t += left / speed;
  }
  return t;
}

}  // namespace stroma::collision
