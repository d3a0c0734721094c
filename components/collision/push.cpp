// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/collision/push.h"

#include <Eigen/Geometry>
#include <cmath>

#include "framework/mechanics/frames.h"

namespace stroma::collision {

void addSide(const CollisionModel& model, const PartPoint& point, double sign, Push& push) {
  const State& state = model.state();
  std::array<Vec3, 3> places;
  model.corners(*point.part, places);
  std::size_t at = sign < 0 ? 0 : 3;
  for (std::size_t i = 0; i < std::size_t(point.part->corners); ++i, ++at)
    if (state.isBound())
      push.rows[at] = state.firstRow() + point.part->node[i] * state.rows_per_node, push.c[at] = sign * point.weight[i];
    else
      push.fixed += sign * point.weight[i] * places[i];
  if (point.part->radius == 0 || !state.isBound() || !state.hasFrames()) return;
  const std::size_t side = sign < 0 ? 0 : 1;
  push.turns[side] = state.firstRow() + point.part->node[0] * state.rows_per_node + 1, push.radii[side] = point.part->radius;
}

Vec3 wayOf(const Push& push, ConstRows x) {
  Vec3 way = push.fixed;
  for (std::size_t i = 0; i < 6; ++i)
    if (push.rows[i] >= 0) way += push.c[i] * x[push.rows[i]];
  return way;
}

double depth(const Push& push, ConstRows x) { return push.d - push.n.dot(wayOf(push, x)); }

Vec3 slid(const Push& push, ConstRows x, ConstRows x_start) {
  Vec3 way = wayOf(push, x) - wayOf(push, x_start);
  for (std::size_t side = 0; side < 2; ++side)
    if (const Index row = push.turns[side]; row >= 0)
      way -= push.radii[side] * rotationVector(orientationIn(x, row) * orientationIn(x_start, row).conjugate()).cross(push.n);
  return way;
}

double shareInTouch(const Push& push, ConstRows x, ConstRows x_start) {
  Vec3 of_p = Vec3::Zero(), of_q = Vec3::Zero();
  for (std::size_t i = 0; i < 6; ++i)
    if (push.rows[i] >= 0) (i < 3 ? of_p : of_q) += push.c[i] * (x[push.rows[i]] - x_start[push.rows[i]]);
  const double before = -depth(push, x_start), after = -depth(push, x), little = 1e-5 * (of_p.norm() + of_q.norm());
  if (std::abs(before) < little && std::abs(after) < little) return 1;
  if (!(std::abs(before - after) > 1e-3 * before)) return 1;
  const double met = before / (before - after);
  if (met > 0 && met < 1) return 1 - met;
  return after < 0 ? 1 : 0;
}

}  // namespace stroma::collision
