// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tests/contact/every_pair.h"

#include <algorithm>
#include <cmath>

#include "components/contact/longest_step.h"
#include "framework/collision/exact_intersection.h"

namespace stroma::test {
namespace {

using contact::Surfaces;

/// visit(kind, first, second, its points) of every pair of two sides that share no vertex; obstacles do not meet each other.
template <class Visit>
void forEachPair(const Surfaces& s, Visit&& visit) {
  const auto meet = [&](int a, int b) { return s.moves(a) || s.moves(b); };
  for (std::size_t v = 0; v < s.rows.size(); ++v)
    for (std::size_t f = 0; f < s.faces.size(); ++f) {
      const auto& [a, b, c] = s.faces[f];
      if (meet(int(v), a) && int(v) != a && int(v) != b && int(v) != c)
        visit(PairKind::point_triangle, int(v), int(f), std::array{int(v), a, b, c});
    }
  for (std::size_t e = 0; e < s.edges.size(); ++e)
    for (std::size_t g = e + 1; g < s.edges.size(); ++g) {
      const auto& [a, b] = s.edges[e];
      const auto& [c, d] = s.edges[g];
      if (meet(a, c) && a != c && a != d && b != c && b != d)
        visit(PairKind::edge_edge, int(e), int(g), std::array{a, b, c, d});
    }
}

FourPoints at(const std::array<int, 4>& v, const std::vector<Vec3>& x) {
  return {x[std::size_t(v[0])], x[std::size_t(v[1])], x[std::size_t(v[2])], x[std::size_t(v[3])]};
}

double radiusAt(const Surfaces& s, int vertex) {
  return s.radius[std::size_t(s.faces_around.values[std::size_t(s.faces_around.start[std::size_t(vertex)])])];
}

}  // namespace

std::vector<Key> pairsNearerThan(double reach, const Surfaces& s, const std::vector<Vec3>& x) {
  std::vector<Key> found;
  forEachPair(s, [&](PairKind kind, int first, int second, const std::array<int, 4>& v) {
    const double radii = radiusAt(s, v[0]) + radiusAt(s, v[3]);
    if (closestPoints(kind, at(v, x)).distance() - radii < reach) found.emplace_back(kind, first, second);
  });
  return found;
}

std::set<std::pair<int, int>> allCrossings(const Surfaces& s, const std::vector<Vec3>& x) {
  std::set<std::pair<int, int>> found;
  const auto place = [&](int v) -> const Vec3& { return x[std::size_t(v)]; };
  for (std::size_t e = 0; e < s.edges.size(); ++e)
    for (std::size_t f = 0; f < s.faces.size(); ++f) {
      const auto& [p, q] = s.edges[e];
      const auto& [a, b, c] = s.faces[f];
      if ((!s.moves(p) && !s.moves(a)) || p == a || p == b || p == c || q == a || q == b || q == c) continue;
      if (segmentMeetsTriangle(place(p), place(q), place(a), place(b), place(c))) found.insert({int(e), int(f)});
    }
  return found;
}

StepsOfAll stepsOfAllPairs(const Surfaces& s, const std::vector<Vec3>& x, const std::vector<Vec3>& way, double reach) {
  constexpr double round_off = 1e-6;
  StepsOfAll steps;
  forEachPair(s, [&](PairKind kind, int, int, const std::array<int, 4>& v) {
    const FourPoints start = at(v, x), along = at(v, way);
    const double radii = radiusAt(s, v[0]) + radiusAt(s, v[3]), room = closestPoints(kind, start).distance() - radii;
    double moves = 0;
    for (const Vec3& each : along) moves = std::max(moves, each.norm());
    if (2 * moves < 0.9 * room) return;
    const double first = longestStep(kind, start, along, {.thickness = radii, .left = 0.1 * (1 + round_off)});
    steps.shorter = std::min(steps.shorter, first);
    if (first >= steps.longer) return;
    const double left = 0.1 * (1 - round_off) * std::min(1.0, reach / room);
    steps.longer = std::min(steps.longer, longestStep(kind, start, along, {.thickness = radii, .left = left}));
  });
  return steps;
}

double Motions::number(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
Vec3 Motions::point() {
  const double x = number(), y = number(), z = number();  // in this order with every compiler
  return {x, y, z};
}
FourPoints Motions::four() {
  FourPoints points;
  for (Vec3& each : points) each = point();
  return points;
}
void Motions::meeting(PairKind kind, double when, int degenerate, double scale, FourPoints& x, FourPoints& dx) {
  FourPoints at = four();
  double u = number(0, 1), w = number(0, 1);
  if (degenerate & 1) u = std::round(u);
  if (degenerate & 2) w = std::round(w);
  if (degenerate & 4) at[3] = at[2] + (degenerate & 8 ? 1e-9 : 1e-3) * point();
  if (degenerate & 16) {
    const double size = 1e-7 * number();
    at[1] = at[0] + (at[3] - at[2]) + size * point();
  }
  const Vec3 second = kind == PairKind::edge_edge ? Vec3((1 - w) * at[2] + w * at[3])
                                                  : Vec3((1 - u) * at[1] + u * ((1 - w) * at[2] + w * at[3]));
  const Vec3 first = kind == PairKind::edge_edge ? Vec3((1 - u) * at[0] + u * at[1]) : at[0];
  at[0] += second - first;
  if (kind == PairKind::edge_edge) at[1] += second - first;
  dx = four();
  const double size = std::pow(10, number(-3, 2));
  for (std::size_t i = 0; i < 4; ++i) {
    if (degenerate & 32) dx[i] = i < (kind == PairKind::edge_edge ? 2u : 1u) ? dx[0] : dx[3];
    dx[i] *= size * scale;
    x[i] = scale * at[i] - when * dx[i];
  }
}

double smallestDistance(PairKind kind, const FourPoints& x, const FourPoints& dx, double until) {
  double least = 1e300;
  for (int i = 0; i <= 200; ++i) {
    FourPoints now;
    for (std::size_t k = 0; k < 4; ++k) now[k] = x[k] + until * i / 200 * dx[k];
    least = std::min(least, closestPoints(kind, now).distance());
  }
  return least;
}

}  // namespace stroma::test
