// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/contact/contact_rims.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <span>

namespace stroma::contact {

/// The touch is of a vertex beside a sharp rim of a surface that its own surface lies along: `along` is the normal of the one at the rim.
static bool slidesPast(const Surfaces& surfaces, const std::vector<Vec3>& x, const Touch& touch, Vec3& along) {
  constexpr double opposite = -0.9, straight = 0.999, sharp = 0.8;
  const auto normalOf = [&](Index face, double side) {
    const auto& [a, b, c] = surfaces.faces[std::size_t(face)];
    const Vec3& p = x[std::size_t(a)];
    const Vec3 n = (x[std::size_t(b)] - p).cross(x[std::size_t(c)] - p).normalized();
    return !surfaces.isOneSided(a) && side * n.dot(touch.n) < 0 ? Vec3(-n) : n;
  };
  const auto around = [&](std::size_t v) {
    const Adjacency& faces = surfaces.faces_around;
    return std::span(faces.values).subspan(std::size_t(faces.start[v]), std::size_t(faces.start[v + 1] - faces.start[v]));
  };
  const auto isAt = [&](Index face, std::size_t k) {
    return touch.c[k] == 0 || std::ranges::count(surfaces.faces[std::size_t(face)], touch.v[k]) > 0;
  };
  const std::size_t first = touch.c[1] != 0 ? 1 : touch.c[2] != 0 ? 2 : 3;
  double least = opposite, steepest = 1;
  for (const Index face : around(std::size_t(touch.v[first]))) {
    if (!isAt(face, 1) || !isAt(face, 2) || !isAt(face, 3)) continue;
    const Vec3 n = normalOf(face, 1);
    if (n.dot(touch.n) > straight) return false;
    steepest = std::min(steepest, n.dot(touch.n));
    for (const Index own : around(std::size_t(touch.v[0]))) {
      const Vec3 other = normalOf(own, -1);
      if (other.dot(touch.n) < 0 && n.dot(other) < least) least = n.dot(other), along = n;
    }
  }
  return least < opposite && steepest < sharp;
}

void leaveRims(const BarrierLaw& law, const std::vector<Vec3>& x, std::vector<Touch>& touches) {
  constexpr double steep = 0.7;
  std::erase_if(touches, [&](Touch& touch) {
    Vec3 along;
    if (!touch.of_surface || touch.v[1] < 0 || touch.c[1] * touch.c[2] * touch.c[3] != 0) return false;
    if (!slidesPast(law.surfaces, x, touch, along)) return false;
    const double part = along.dot(touch.n);
    if (part <= steep) return touch.gap >= touch.range;
    touch.gap -= (1 - part) * (touch.gap + law.thickness), touch.n = along;
    return false;
  });
}

}  // namespace stroma::contact
