// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/contact/contact_inside.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <utility>

namespace stroma::contact {
namespace {

/// How often the surfaces that have an inside and that count go around a place: the sum of solid angles (Van Oosterom and
/// Strackee 1983).
template <class Counts>
double turnsAround(const Vec3& place, const Surfaces& surfaces, const std::vector<Vec3>& x, Counts&& counts) {
  double angles = 0;
  for (const auto& face : surfaces.faces) {
    if (!surfaces.isOneSided(face[0]) || !counts(face[0])) continue;
    const Vec3 a = x[std::size_t(face[0])] - place, b = x[std::size_t(face[1])] - place, c = x[std::size_t(face[2])] - place;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    angles += 2 * std::atan2(a.cross(b).dot(c), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return angles / (4 * M_PI);
}

}  // namespace

bool isInside(const Vec3& place, const Surfaces& surfaces, const std::vector<Vec3>& x, int body) {
  return turnsAround(place, surfaces, x, [&](int vertex) { return surfaces.bodyOf(vertex) == body; }) > 0.5;
}

void refuseInside(const std::string& path, const Surfaces& surfaces, const std::vector<Vec3>& x,
                  const std::function<std::string(int)>& name) {
  std::vector<char> is_known(x.size(), false);  // pieces
  for (int v = 0; v < int(x.size()); ++v) {
    const Vec3& place = x[std::size_t(v)];
    const auto ofOthers = [&](int other) { return surfaces.moves(other) && surfaces.bodyOf(other) != surfaces.bodyOf(v); };
    if ((surfaces.moves(v) && !name) || std::exchange(is_known[std::size_t(surfaces.pieceOf(v))], true) ||
        !(turnsAround(place, surfaces, x, ofOthers) > 0.5))
      continue;
    const bool moves = surfaces.moves(v);
    throw ComponentError(fmt::format("{} of {} is inside of {}, at {:.4g} {:.4g} {:.4g}", moves ? name(v) : "an obstacle", path,
                                     moves ? "another body" : "a body", place.x(), place.y(), place.z()),
                         "a start with gaps everywhere");
  }
}

}  // namespace stroma::contact
