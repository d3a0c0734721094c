// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/contact/wrenches.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "framework/mechanics/state.h"
#include "framework/scene/archive.h"
#include "framework/scene/data.h"

namespace stroma::contact {

void Wrenches::declare(DataTable& table) {
  table.add("wrenches", of_bodies_)
      .help("on each body, mstate first: the sum of its contact forces with friction [N], and their moment about the "
            "origin [N m]")
      .output();
  table.add("pairs", names_)
      .help("the bodies of each pair, two names for each: every two states, then each of them with the obstacles")
      .output();
  table.add("pairWrenches", of_pairs_)
      .help("of each of pairs: the force of the second on the first, with friction [N], and its moment about the origin [N m]")
      .output();
}

void Wrenches::compile(const BarrierLaw& law, const std::vector<State*>& bodies) {
  const auto& all = law.surfaces.bodies();
  const bool has_obstacles =
      !law.planes.empty() || std::any_of(all.begin(), all.end(), [](const Surfaces::Body& body) { return !body.moves; });
  bodies_ = bodies.size(), last_ = bodies_ - 1 + std::size_t(has_obstacles);
  names_.clear();
  for (std::size_t i = 0; i < bodies_; ++i)
    for (std::size_t j = i + 1; j <= last_; ++j) {
      names_.push_back(bodies[i]->path());
      names_.push_back(j < bodies_ ? bodies[j]->path() : "obstacles");
    }
}

std::size_t Wrenches::bodyOf(const Surfaces& surfaces, int vertex) const {
  return vertex >= 0 && surfaces.moves(vertex) ? std::size_t(surfaces.bodyOf(vertex)) : bodies_;
}

void Wrenches::add(const Surfaces& surfaces, const std::array<int, 4>& v, const std::array<double, 4>& c,
                   const std::vector<Vec3>& x, const Vec3& force) {
  const std::size_t a = bodyOf(surfaces, v[0]), b = bodyOf(surfaces, v[3]);
  const std::size_t first = std::min(a, b), second = std::max(a, b);
  const std::size_t pair = first * last_ - first * (first - 1) / 2 + (second - first - 1);
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t body = v[i] < 0 ? bodies_ : bodyOf(surfaces, v[i]);
    if (body == bodies_) continue;
    const Vec3 here = c[i] * force, moment = x[std::size_t(v[i])].cross(here);
    of_bodies_[2 * body] += here, of_bodies_[2 * body + 1] += moment;
    if (a != b && body == first) of_pairs_[2 * pair] += here, of_pairs_[2 * pair + 1] += moment;
  }
}

void Wrenches::serialize(Archive& archive) {
  archive.list("wrenches", of_bodies_), archive.list("pair_wrenches", of_pairs_);
}

}  // namespace stroma::contact
