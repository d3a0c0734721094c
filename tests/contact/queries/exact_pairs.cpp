// SPDX-License-Identifier: LGPL-2.1-or-later
// In a source of its own, which is compiled with optimisation: rational numbers take a multiple without.
#include "tests/contact/exact_pairs.h"

#include <algorithm>
#include <cmath>

namespace stroma::test::exact_pairs {

Exact exact(const Vec3& p) { return {Rational(p.x()), Rational(p.y()), Rational(p.z())}; }
std::array<Exact, 4> exact(const FourPoints& x) { return {exact(x[0]), exact(x[1]), exact(x[2]), exact(x[3])}; }
Exact operator-(const Exact& a, const Exact& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Exact operator+(const Exact& a, const Exact& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Exact operator*(const Rational& s, const Exact& a) { return {s * a[0], s * a[1], s * a[2]}; }
Rational dot(const Exact& a, const Exact& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Exact cross(const Exact& a, const Exact& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Rational square(const Exact& a) { return dot(a, a); }

namespace {

// Distances are of whole numbers, all coordinates times what their denominators have in common, and are divided once:
// rational numbers look for a common factor in each sum.
using Whole = boost::multiprecision::cpp_int;
using Places = std::array<Whole, 3>;

Places operator-(const Places& a, const Places& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Whole dot(const Places& a, const Places& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Places cross(const Places& a, const Places& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

struct Fraction {
  Whole above, below = 1;  ///< below > 0
  bool operator<(const Fraction& other) const { return above * other.below < other.above * below; }
};

/// Squared distances of a point from a segment, of two segments, of a point from a triangle.
Fraction ofSegment(const Places& p, const Places& a, const Places& b) {
  const Places along = b - a, way = p - a;
  const Whole length = dot(along, along), s = dot(way, along);
  if (s <= 0) return {dot(way, way)};  // and where a segment is a point
  if (s >= length) return {dot(p - b, p - b)};
  return {dot(way, way) * length - s * s, length};
}
Fraction ofSegments(const Places& a, const Places& b, const Places& c, const Places& d) {
  const Fraction best = std::min({ofSegment(a, c, d), ofSegment(b, c, d), ofSegment(c, a, b), ofSegment(d, a, b)});
  const Places u = b - a, v = d - c, w = a - c, n = cross(u, v);
  const Whole size = dot(n, n);
  if (size == 0) return best;
  const Whole s = dot(cross(v, w), n), t = dot(cross(u, w), n), height = dot(w, n);
  if (s < 0 || s > size || t < 0 || t > size) return best;
  return std::min(best, Fraction{height * height, size});
}
Fraction ofTriangle(const Places& p, const Places& a, const Places& b, const Places& c) {
  const Fraction best = std::min({ofSegment(p, a, b), ofSegment(p, b, c), ofSegment(p, c, a)});
  const Places n = cross(b - a, c - a);
  const Whole size = dot(n, n), height = dot(p - a, n);
  if (size == 0) return best;
  const auto side = [&](const Places& q, const Places& r) { return dot(cross(r - q, p - q), n); };
  if (side(a, b) < 0 || side(b, c) < 0 || side(c, a) < 0) return best;
  return std::min(best, Fraction{height * height, size});
}

}  // namespace

Rational squaredDistance(PairKind kind, const std::array<Exact, 4>& x) {
  Whole common = 1;
  for (const Exact& point : x)
    for (const Rational& number : point) common = lcm(common, denominator(number));
  std::array<Places, 4> at;
  for (std::size_t k = 0; k < 4; ++k)
    for (std::size_t c = 0; c < 3; ++c) at[k][c] = numerator(x[k][c]) * (common / denominator(x[k][c]));
  const Fraction found =
      kind == PairKind::edge_edge ? ofSegments(at[0], at[1], at[2], at[3]) : ofTriangle(at[0], at[1], at[2], at[3]);
  return Rational(found.above, found.below * common * common);
}

int Numbers::whole(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }
Vec3 Numbers::point() {
  const int x = whole(-1024, 1024), y = whole(-1024, 1024),
            z = whole(-1024, 1024);  // in this order with every compiler
  return Vec3(x, y, z) / 1024;
}

void makeMeeting(Numbers& numbers, PairKind kind, unsigned degenerate, double& when, FourPoints& x, FourPoints& dx) {
  FourPoints at;
  for (Vec3& point : at) point = numbers.point();
  double u = numbers.whole(0, 64) / 64., w = numbers.whole(0, 64) / 64.;
  if (degenerate & 1) u = std::round(u);                                               // at a corner
  if (degenerate & 2) w = std::round(w);                                               // on an edge
  if (degenerate & 4) at[3] = at[2];                                                   // no length, no area
  if (degenerate & 8) at[1] = at[0] + (at[3] - at[2]);                                 // parallel
  if (degenerate & 16) at[3] = at[2] + (at[2] - at[1]) + numbers.point() / (1 << 20);  // a sliver
  const bool edges = kind == PairKind::edge_edge;
  const Vec3 second =
      edges ? Vec3((1 - w) * at[2] + w * at[3]) : Vec3((1 - u) * at[1] + u * ((1 - w) * at[2] + w * at[3]));
  const Vec3 first = edges ? Vec3((1 - u) * at[0] + u * at[1]) : at[0];
  at[0] += second - first;
  if (edges) at[1] += second - first;
  when = numbers.whole(1, 1023) / 1024.;
  for (Vec3& way : dx) {
    way = numbers.point();
    way *= std::ldexp(1, numbers.whole(-3, 3));
  }
  if (degenerate & 32) dx[3] = dx[2] = dx[1] = edges ? dx[2] : dx[1];  // a side that does not turn
  for (std::size_t i = 0; i < 4; ++i) x[i] = at[i] - when * dx[i];
}

}  // namespace stroma::test::exact_pairs
