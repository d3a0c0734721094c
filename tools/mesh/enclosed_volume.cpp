// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/mesh/enclosed_volume.h"

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <numbers>

namespace stroma {

namespace {

std::vector<Triangle> mergedTriangles(const std::vector<Vec3>& position, const std::vector<Triangle>& triangles) {
  std::map<std::array<double, 3>, Index> first;
  std::vector<Index> merged;
  for (std::size_t n = 0; n < position.size(); ++n) {
    const Vec3& p = position[n];
    merged.push_back(first.try_emplace({p.x(), p.y(), p.z()}, Index(n)).first->second);
  }
  std::vector<Triangle> out;
  for (const Triangle& t : triangles) {
    const Triangle m{merged[t[0]], merged[t[1]], merged[t[2]]};
    if (m[0] != m[1] && m[1] != m[2] && m[2] != m[0]) out.push_back(m);
  }
  return out;
}

Edge sorted(Index a, Index b) { return a < b ? Edge{a, b} : Edge{b, a}; }

bool runsAlong(const Triangle& t, Index a, Index b) {
  return (t[0] == a && t[1] == b) || (t[1] == a && t[2] == b) || (t[2] == a && t[0] == b);
}

/// The shells, the triangles of each turned alike; empty when that cannot be.
std::vector<std::vector<Triangle>> shellsOf(std::vector<Triangle> triangles) {
  std::map<Edge, std::vector<std::size_t>> at;
  for (std::size_t i = 0; i < triangles.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) at[sorted(triangles[i][k], triangles[i][(k + 1) % 3])].push_back(i);
  for (const auto& [edge, sides] : at)
    if (sides.size() != 2) return {};
  std::vector<char> seen(triangles.size(), 0);
  std::vector<std::vector<Triangle>> shells;
  std::vector<std::size_t> open;
  for (std::size_t start = 0; start < triangles.size(); ++start) {
    if (seen[start]) continue;
    shells.emplace_back();
    seen[start] = 1;
    for (open.push_back(start); !open.empty();) {
      const Triangle own = triangles[open.back()];
      const std::size_t number = open.back();
      open.pop_back();
      shells.back().push_back(own);
      for (std::size_t k = 0; k < 3; ++k) {
        const Index a = own[k], b = own[(k + 1) % 3];
        const auto& sides = at[sorted(a, b)];
        const std::size_t other = sides[0] == number ? sides[1] : sides[0];
        if (runsAlong(triangles[other], a, b)) {
          if (seen[other]) return {};
          std::swap(triangles[other][1], triangles[other][2]);
        }
        if (!seen[other]) seen[other] = 1, open.push_back(other);
      }
    }
  }
  return shells;
}

/// The solid angle of a triangle seen from p (Van Oosterom and Strackee 1983).
double solidAngle(const Vec3& p, const std::array<Vec3, 3>& corner) {
  const Vec3 a = corner[0] - p, b = corner[1] - p, c = corner[2] - p;
  const double u = a.norm(), v = b.norm(), w = c.norm();
  return 2 * std::atan2(a.dot(b.cross(c)), u * v * w + a.dot(b) * w + b.dot(c) * u + c.dot(a) * v);
}

}  // namespace

std::optional<Enclosed> enclosedBy(const std::vector<Vec3>& position, const std::vector<Triangle>& triangles) {
  const std::vector<std::vector<Triangle>> shells = shellsOf(mergedTriangles(position, triangles));
  if (shells.empty()) return {};
  const auto cornersOf = [&position](const Triangle& t) {
    return std::array<Vec3, 3>{position[t[0]], position[t[1]], position[t[2]]};
  };
  Enclosed out;
  out.shells = int(shells.size());
  for (const auto& shell : shells) {
    const Vec3& origin = position[shell[0][0]];
    double volume = 0;
    for (const Triangle& t : shell) {
      const auto p = cornersOf(t);
      out.area += (p[1] - p[0]).cross(p[2] - p[0]).norm() / 2;
      volume += (p[0] - origin).dot((p[1] - origin).cross(p[2] - origin)) / 6;
    }
    int around = 0;
    for (const auto& other : shells) {
      if (&other == &shell) continue;
      double angle = 0;
      for (const Triangle& t : other) angle += solidAngle(origin, cornersOf(t));
      around += std::abs(angle) > 2 * std::numbers::pi;
    }
    out.volume += (around % 2 ? -1 : 1) * std::abs(volume);
  }
  return out;
}

}  // namespace stroma
