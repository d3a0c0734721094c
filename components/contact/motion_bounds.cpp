// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/contact/motion_bounds.h"

#include <algorithm>
#include <cmath>

#include "framework/scene/archive.h"

namespace stroma::contact {

void MotionBounds::measure(const Surfaces& surfaces, const std::vector<Vec3>& start, const std::vector<Vec3>& x) {
  if (start.size() != x.size() || surfaces.areBodiesAt(x, start)) return;
  travel_ = 0, travels_.assign(surfaces.bodies().size(), 0);
  for (std::size_t v = 0; v < x.size(); ++v) {
    if (!surfaces.moves(int(v))) continue;
    double& of_body = travels_[std::size_t(surfaces.bodyOf(int(v)))];
    of_body = std::max(of_body, (x[v] - start[v]).norm()), travel_ = std::max(travel_, of_body);
  }
}

/// Of a body no less than conditions are made for (KeptGaps::addPairs()).
void MotionBounds::find(const BarrierLaw& law, const std::vector<State*>& states, double dt, const Vec3& of_obstacles) {
  const Surfaces& s = law.surfaces;
  double most = 0;
  of_bodies_.resize(s.bodies().size());
  for (std::size_t b = 0; b < s.bodies().size(); ++b) {
    const Surfaces::Body& each = s.bodies()[b];
    double by_speed = each.moves ? 0 : of_obstacles.norm();
    if (each.moves && each.vertices > 0) {
      const State& state = *states[std::size_t(s.bodyOf(each.first_vertex))];
      const ConstRows v = state.v();
      double square = 0;
      for (int i = each.first_vertex; i < each.first_vertex + each.vertices; ++i)
        square = std::max(square, (dt * Vec3(v[s.rows[std::size_t(i)] - state.firstRow()])).squaredNorm());
      by_speed = std::sqrt(square), most = std::max(most, by_speed);
    }
    const double before = each.moves && b < travels_.size() ? travels_[b] : 0;
    of_bodies_[b] = 2 * std::max(before, by_speed) + of_edge * lengthOf(law);
  }
  way_ = std::max({2 * travel_, 2 * most, of_edge * lengthOf(law)});
}

void MotionBounds::expect(const BarrierLaw& law, const std::vector<State*>& states, double dt, const Vec3& of_obstacles,
                      const std::vector<Vec3>& start, const std::vector<Vec3>& x) {
  const Surfaces& s = law.surfaces;
  expected_.last.assign(x.size(), of_obstacles), expected_.straight.assign(x.size(), of_obstacles);
  for (std::size_t v = 0; v < x.size(); ++v) {
    if (!s.moves(int(v))) continue;
    const State& state = *states[std::size_t(s.bodyOf(int(v)))];
    expected_.straight[v] = dt * Vec3(state.v()[s.rows[v] - state.firstRow()]);
    expected_.last[v] = start.size() == x.size() ? Vec3(x[v] - start[v]) : Vec3(Vec3::Zero());
  }
  expected_.other = 2 * of_edge * lengthOf(law);
}

void MotionBounds::serialize(Archive& archive) {
  archive.value("travel", travel_);
  archive.list("travels", travels_);
  archive.value("way", way_);
}

}  // namespace stroma::contact
