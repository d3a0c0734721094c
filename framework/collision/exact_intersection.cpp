// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/collision/exact_intersection.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace stroma {
namespace {

/// A number as a sum of doubles that do not overlap, smallest first; no zeros.
using Expansion = std::vector<double>;

/// sum + error = a + b, exactly.
void twoSum(double a, double b, double& sum, double& error) {
  sum = a + b;
  const double part = sum - a;
  error = (a - (sum - part)) + (b - part);
}

void add(Expansion& e, double b) {
  std::size_t kept = 0;
  for (const double term : e) {
    double error;
    twoSum(b, term, b, error);
    if (error != 0) e[kept++] = error;
  }
  e.resize(kept);
  if (b != 0) e.push_back(b);
}

Expansion operator+(Expansion a, const Expansion& b) {
  for (const double term : b) add(a, term);
  return a;
}

Expansion operator*(const Expansion& a, const Expansion& b) {
  Expansion product;
  for (const double p : a)
    for (const double q : b) {
      const double high = p * q;
      add(product, std::fma(p, q, -high));
      add(product, high);
    }
  return product;
}

Expansion operator-(Expansion a) {
  for (double& term : a) term = -term;
  return a;
}

Expansion difference(double a, double b) {
  Expansion e;
  add(e, a), add(e, -b);
  return e;
}

int signOf(const Expansion& e) { return e.empty() ? 0 : e.back() > 0 ? 1 : -1; }

/// Scaled by a power of two, so that no product leaves the range of doubles.
std::array<Vec3, 4> scaled(std::array<Vec3, 4> x) {
  double largest = 0;
  for (const Vec3& p : x) largest = std::max(largest, p.cwiseAbs().maxCoeff());
  const int shift = largest > 0 ? 300 - std::ilogb(largest) : 0;
  for (Vec3& p : x)
    for (int c = 0; c < 3; ++c) p[c] = std::ldexp(p[c], shift);
  return x;
}

int exactOrientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const auto x = scaled({a, b, c, d});
  Expansion m[3][3];
  for (std::size_t i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) m[i][k] = difference(x[i][k], x[3][k]);
  Expansion sum;
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3, n = (k + 2) % 3;
    sum = sum + m[2][k] * (m[0][l] * m[1][n] + -(m[0][n] * m[1][l]));
  }
  return signOf(sum);
}

/// Of a determinant as rounded, with terms of these sizes. Shewchuk's bound is 7.8e-16 where all numbers are normal ones.
bool hasItsSign(double determinant, double sizes) {
  return sizes > 1e-250 && std::abs(determinant) > 1e-15 * sizes && std::isfinite(sizes);
}

/// The sign of (b - a) x (c - a) seen along the axis `drop`.
int orientation2(const Vec3& a, const Vec3& b, const Vec3& c, int drop) {
  const int l = (drop + 1) % 3, n = (drop + 2) % 3;
  const Vec3 u = b - a, v = c - a;
  const double first = u[l] * v[n], second = u[n] * v[l];
  if (hasItsSign(first - second, std::abs(first) + std::abs(second))) return first > second ? 1 : -1;
  if ((u[l] == 0 && v[l] == 0) || (u[n] == 0 && v[n] == 0)) return 0;
  const auto x = scaled({a, b, c, a});
  return signOf(difference(x[1][l], x[0][l]) * difference(x[2][n], x[0][n]) +
                -(difference(x[1][n], x[0][n]) * difference(x[2][l], x[0][l])));
}

bool inBox(const Vec3& p, const Vec3& a, const Vec3& b) {
  return (p.array() >= a.cwiseMin(b).array()).all() && (p.array() <= a.cwiseMax(b).array()).all();
}

/// Two segments of one plane, which the projection along `drop` maps one to one.
bool segmentsMeet(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, int drop) {
  const int ac = orientation2(a, b, c, drop), ad = orientation2(a, b, d, drop);
  const int ca = orientation2(c, d, a, drop), cb = orientation2(c, d, b, drop);
  if (ac * ad < 0 && ca * cb < 0) return true;
  return (ac == 0 && inBox(c, a, b)) || (ad == 0 && inBox(d, a, b)) || (ca == 0 && inBox(a, c, d)) || (cb == 0 && inBox(b, c, d));
}

/// An axis along which some three of the points are no line, or -1.
int planeAxis(const std::vector<Vec3>& x) {
  for (int drop = 0; drop < 3; ++drop)
    for (std::size_t i = 2; i < x.size(); ++i)
      for (std::size_t j = 1; j < i; ++j)
        for (std::size_t k = 0; k < j; ++k)
          if (orientation2(x[k], x[j], x[i], drop) != 0) return drop;
  return -1;
}

/// All points are known to lie in one plane, and the boxes of both to meet.
bool meetInPlane(const Vec3& p, const Vec3& q, const std::array<Vec3, 3>& t) {
  const int drop = planeAxis({p, q, t[0], t[1], t[2]});
  if (drop < 0) return true;  // of one line, whose boxes meet
  for (std::size_t i = 0; i < 3; ++i)
    if (segmentsMeet(p, q, t[i], t[(i + 1) % 3], drop)) return true;
  const auto side = [&](std::size_t i) { return orientation2(t[i], t[(i + 1) % 3], p, drop); };
  return side(0) != 0 && side(0) == side(1) && side(1) == side(2);
}

}  // namespace

int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 x = a - d, y = b - d, z = c - d;
  const double xy = x.x() * y.y(), yx = x.y() * y.x(), yz = x.y() * y.z(), zy = x.z() * y.y(), zx = x.z() * y.x(), xz = x.x() * y.z();
  const double determinant = z.z() * (xy - yx) + z.x() * (yz - zy) + z.y() * (zx - xz);
  const double sizes = std::abs(z.z()) * (std::abs(xy) + std::abs(yx)) + std::abs(z.x()) * (std::abs(yz) + std::abs(zy)) +
                       std::abs(z.y()) * (std::abs(zx) + std::abs(xz));
  if (hasItsSign(determinant, sizes)) return determinant > 0 ? 1 : -1;
  if ((x.array() == 0 && y.array() == 0 && z.array() == 0).any()) return 0;  // a plane along two axes, as of many sheets
  return exactOrientation(a, b, c, d);
}

bool segmentMeetsTriangle(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
  if ((p.cwiseMax(q).array() < low.array()).any() || (p.cwiseMin(q).array() > high.array()).any()) return false;
  const int at_p = orientation(a, b, c, p), at_q = orientation(a, b, c, q);
  if (at_p * at_q > 0) return false;
  const std::array<int, 3> sides{orientation(p, q, a, b), orientation(p, q, b, c), orientation(p, q, c, a)};
  // a triangle without area lies in many planes
  if (at_p == 0 && at_q == 0) return sides[0] == 0 && sides[1] == 0 && sides[2] == 0 && meetInPlane(p, q, {a, b, c});
  const auto [least, most] = std::minmax_element(sides.begin(), sides.end());
  return *least >= 0 || *most <= 0;
}

}  // namespace stroma
