// SPDX-License-Identifier: LGPL-2.1-or-later
// The certificate against arithmetic in rational numbers, whose determinants are computed in another way.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <random>

#include "framework/collision/exact_intersection.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

using Rational = boost::multiprecision::cpp_rational;
using Exact = std::array<Rational, 3>;

Exact exact(const Vec3& p) { return {Rational(p.x()), Rational(p.y()), Rational(p.z())}; }
Exact minus(const Exact& a, const Exact& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Rational dot(const Exact& a, const Exact& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Exact cross(const Exact& a, const Exact& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
int signOf(const Rational& r) { return r > 0 ? 1 : r < 0 ? -1 : 0; }

/// The segment is cut with the plane and the point tested in the triangle, or clipped at the triangle's edges where it lies in the plane.
bool meets(const std::array<Vec3, 5>& x) {
  const Exact p = exact(x[0]), q = exact(x[1]), t[3] = {exact(x[2]), exact(x[3]), exact(x[4])};
  const Exact n = cross(minus(t[1], t[0]), minus(t[2], t[0])), d = minus(q, p);
  const Rational height = dot(n, minus(p, t[0])), rate = dot(n, d);
  Rational low = 0, high = 1;
  if (rate == 0) {
    if (height != 0) return false;
  } else {
    low = high = -height / rate;
    if (low < 0 || low > 1) return false;
  }
  for (int i = 0; i < 3; ++i) {  // inside: in . (p + s d - t_i) >= 0
    const Exact in = cross(n, minus(t[(i + 1) % 3], t[i]));
    const Rational at = dot(in, minus(p, t[i])), slope = dot(in, d);
    if (slope == 0) {
      if (at < 0) return false;
    } else if (const Rational s = -at / slope; slope > 0) {
      low = std::max(low, s);
    } else {
      high = std::min(high, s);
    }
  }
  return low <= high;
}
bool flat(const std::array<Vec3, 5>& x) {
  const Exact n = cross(minus(exact(x[3]), exact(x[2])), minus(exact(x[4]), exact(x[2])));
  return n[0] == 0 && n[1] == 0 && n[2] == 0;
}

class Pairs {
 public:
  double number() { return uniform_(random_); }
  Vec3 point() { return {number(), number(), number()}; }
  /// Coordinates of a coarse lattice: most determinants of such points vanish often.
  Vec3 corner(int count) {
    std::uniform_int_distribution<int> cell(0, count);
    return {double(cell(random_)), double(cell(random_)), double(cell(random_))};
  }

 private:
  std::mt19937 random_{3};
  std::uniform_real_distribution<double> uniform_{-1, 1};
};

bool ours(const std::array<Vec3, 5>& x) { return segmentMeetsTriangle(x[0], x[1], x[2], x[3], x[4]); }

/// Of the parallelepiped over four points, in numbers: some millions of them, compiled without optimisation.
double volume(const double* a, const double* b, const double* c, const double* d) {
  const double u0 = a[0] - d[0], u1 = a[1] - d[1], u2 = a[2] - d[2], v0 = b[0] - d[0], v1 = b[1] - d[1],
               v2 = b[2] - d[2], w0 = c[0] - d[0], w1 = c[1] - d[1], w2 = c[2] - d[2];
  return std::abs(u0 * (v1 * w2 - v2 * w1) + u1 * (v2 * w0 - v0 * w2) + u2 * (v0 * w1 - v1 * w0));
}

TEST(ExactIntersection, OfRandomPairs) {
  Pairs pairs;
  int meeting = 0, judged = 0;
  for (int i = 0; i < 1000000; ++i) {
    const std::array<Vec3, 5> x{pairs.point(), pairs.point(), pairs.point(), pairs.point(), pairs.point()};
    const bool found = ours(x);
    meeting += found;
    // rational numbers take their time: every pair that is near a decision, and some of the others
    const double *p = x[0].data(), *q = x[1].data(), *s = x[2].data(), *t = x[3].data(), *u = x[4].data();
    const double smallest =
        std::min({volume(s, t, u, p), volume(s, t, u, q), volume(p, q, s, t), volume(p, q, t, u), volume(p, q, u, s)});
    if (smallest > 1e-5 && i % 100 != 0) continue;
    ++judged;
    ASSERT_EQ(found, meets(x)) << "pair " << i;
  }
  EXPECT_GT(meeting, 10000);
  EXPECT_GT(judged, 10000);
}

TEST(ExactIntersection, OfDegeneratePairs) {
  Pairs pairs;
  int meeting = 0;
  for (int i = 0; i < 10000; ++i) {
    std::array<Vec3, 5> x;
    do {
      const int cells = 1 + i % 4;
      for (Vec3& p : x) p = pairs.corner(cells);
      if (i % 3 == 1) x[0] = 0.5 * (x[2] + x[3]);                               // touches an edge, or nearly
      if (i % 3 == 2) x[1] = (x[2] + x[3] + x[4]) / 3 + 1e-17 * pairs.point();  // touches the face, or nearly
      if (i % 5 == 1)
        for (Vec3& p : x) p = 0.1 * p + Vec3(1e3, 1e3 / 3, -1e5);  // lost in round-off
      if (i % 5 == 2)
        for (Vec3& p : x) p *= 1e-90;
      if (i % 5 == 3)
        for (Vec3& p : x) p *= 1e90;
    } while (flat(x));
    meeting += ours(x);
    ASSERT_EQ(ours(x), meets(x)) << "pair " << i;
  }
  EXPECT_GT(meeting, 1000);
}

/// Triangles without area are segments or points.
TEST(ExactIntersection, OfFlatTriangles) {
  const Vec3 o(0, 0, 0), e(1, 0, 0), f(0, 1, 0), g(0, 0, 1);
  EXPECT_TRUE(segmentMeetsTriangle(-f, f, o, e, 2 * e));
  EXPECT_TRUE(segmentMeetsTriangle(-f, f, -e, e, 2 * e));
  EXPECT_FALSE(segmentMeetsTriangle(-f, f, e, 2 * e, 3 * e));
  EXPECT_FALSE(segmentMeetsTriangle(g - f, g + f, -e, e, 2 * e));
  EXPECT_TRUE(segmentMeetsTriangle(o, e, 0.5 * e, 2 * e, 3 * e));
  EXPECT_FALSE(segmentMeetsTriangle(o, e, 2 * e, 2.5 * e, 3 * e));
  EXPECT_TRUE(segmentMeetsTriangle(o, e, o, o, o));
  EXPECT_FALSE(segmentMeetsTriangle(o, e, f, f, f));
  EXPECT_TRUE(segmentMeetsTriangle(o, o, o, e, f));
  EXPECT_FALSE(segmentMeetsTriangle(g, g, o, e, f));
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
