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
    const auto ofOthers = [&](int other) { return surfaces.moves(other) && surfaces.bodyOf(other) != surfaces.bodyOf(v) &&
                                                   !surfaces.areExcluded(surfaces.bodyOf(other), surfaces.bodyOf(v)); };
    if ((surfaces.moves(v) && !name) || std::exchange(is_known[std::size_t(surfaces.pieceOf(v))], true) ||
        !(turnsAround(place, surfaces, x, ofOthers) > 0.5))
      continue;
    const bool moves = surfaces.moves(v);
    throw ComponentError(fmt::format("{} of {} is inside of {}, at {:.4g} {:.4g} {:.4g}", moves ? name(v) : "an obstacle", path,
                                     moves ? "another body" : "a body", place.x(), place.y(), place.z()),
                         "a start with gaps everywhere");
  }
}

/// What starts nearer than the gap that is kept would be thrown out to it.
std::string describeNear(const BarrierLaw& law, const std::vector<Vec3>& x, const std::function<std::string(int)>& nameOf) {
  constexpr double rounding = 1e-6;
  const Surfaces& s = law.surfaces;
  double nearest = (1 - rounding) * law.range;
  int at = -1, from = -1;
  const auto look = [&](double gap, int vertex, int other) {
    if (gap < nearest) nearest = gap, at = vertex, from = other;
  };
  for (const Candidate& pair : law.candidates.pairs()) {
    if (!pair.pushes) continue;
    const double apart = closestPoints(pair.kind, law.candidates.pointsOf(pair, x)).distance();
    const bool is_first = s.moves(pair.v[0]);
    look(apart - pair.radius - law.thickness, is_first ? pair.v[0] : pair.v[3], is_first ? pair.v[3] : pair.v[0]);
  }
  for (std::size_t p = 0; p < law.planes.size(); ++p)
    for (int v = 0; v < int(x.size()); ++v)
      if (s.moves(v)) look(law.gapToPlane(p, std::size_t(v), x[std::size_t(v)]), v, -1);
  if (at < 0) return {};
  return fmt::format("{} starts with a gap of {:.4g} m{}, and contactDistance is {:.4g} m: the first step pushes them as far apart, in "
                     "time as fast as that takes",
                     nameOf(at), nearest, from >= 0 && s.moves(from) ? " from the surface at " + nameOf(from) : "", law.range);
}

}  // namespace stroma::contact
