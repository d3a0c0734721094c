// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/collision/distances.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace stroma {

Vec3 nearestOnSegment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 d = b - a;
  const double squared = d.squaredNorm();
  return squared > 0 ? Vec3(a + std::clamp((p - a).dot(d) / squared, 0., 1.) * d) : a;
}

/// By the regions of Voronoi of corners, sides and the inside.
Vec3 nearestOnTriangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, normal = ab.cross(ac);
  const double area = normal.squaredNorm();
  if (area > 0) {
    const Vec3 ap = p - a;
    const double v = ap.cross(ac).dot(normal) / area, w = ab.cross(ap).dot(normal) / area;
    if (v >= 0 && w >= 0 && v + w <= 1) return a + v * ab + w * ac;
  }
  Vec3 best = nearestOnSegment(p, a, b);
  for (const Vec3& other : {nearestOnSegment(p, b, c), nearestOnSegment(p, c, a)})
    if ((other - p).squaredNorm() < (best - p).squaredNorm()) best = other;
  return best;
}

namespace {

/// Between two segments: where both parameters are free, else at an end of one.
double segmentDistance(const Vec3& p0, const Vec3& p1, const Vec3& q0, const Vec3& q1) {
  const Vec3 u = p1 - p0, v = q1 - q0, w = p0 - q0;
  const double a = u.dot(u), b = u.dot(v), c = v.dot(v), d = u.dot(w), e = v.dot(w), determinant = a * c - b * b;
  double best = std::numeric_limits<double>::infinity();
  if (determinant > 1e-12 * a * c) {
    const double s = (b * e - c * d) / determinant, t = (a * e - b * d) / determinant;
    if (s >= 0 && s <= 1 && t >= 0 && t <= 1) return (w + s * u - t * v).norm();
  }
  for (const Vec3& p : {p0, p1}) best = std::min(best, (nearestOnSegment(p, q0, q1) - p).norm());
  for (const Vec3& q : {q0, q1}) best = std::min(best, (nearestOnSegment(q, p0, p1) - q).norm());
  return best;
}

double pointDistance(const Vec3& p, std::span<const Vec3> b) {
  if (b.size() == 1) return (p - b[0]).norm();
  if (b.size() == 2) return (p - nearestOnSegment(p, b[0], b[1])).norm();
  return (p - nearestOnTriangle(p, b[0], b[1], b[2])).norm();
}

}  // namespace

bool crosses(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  const auto volume = [](const Vec3& w, const Vec3& x, const Vec3& y, const Vec3& z) {
    return (x - w).cross(y - w).dot(z - w);
  };
  const double below = volume(a, b, c, p), above = volume(a, b, c, q);
  if (!(below * above < 0)) return false;
  const double u = volume(p, q, a, b), v = volume(p, q, b, c), w = volume(p, q, c, a);
  return (u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0);
}

double distanceOf(std::span<const Vec3> a, std::span<const Vec3> b) {
  if (a.size() > b.size()) return distanceOf(b, a);
  if (a.size() == 1) return pointDistance(a[0], b);
  if (a.size() == 2 && b.size() == 2) return segmentDistance(a[0], a[1], b[0], b[1]);
  double best = std::numeric_limits<double>::infinity();
  for (const Vec3& p : a) best = std::min(best, pointDistance(p, b));
  for (const Vec3& q : b) best = std::min(best, pointDistance(q, a));
  const std::size_t sides = a.size() == 2 ? 1 : 3;
  for (std::size_t i = 0; i < sides; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      const Vec3 &p = a[i], &q = a[(i + 1) % a.size()], &r = b[j], &s = b[(j + 1) % 3];
      best = std::min(best, segmentDistance(p, q, r, s));
      if (crosses(p, q, b[0], b[1], b[2]) || (a.size() == 3 && crosses(r, s, a[0], a[1], a[2]))) return 0;
    }
  return best;
}

}  // namespace stroma
