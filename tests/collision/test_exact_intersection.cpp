// SPDX-License-Identifier: LGPL-2.1-or-later
// The certificate against exact arithmetic, which cuts and clips where the certificate has signs of determinants.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <random>

#include "framework/collision/exact_intersection.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

// In whole numbers, all coordinates times one power of two: rational numbers look for a common factor in each sum.
using Whole = boost::multiprecision::cpp_int;
using Exact = std::array<Whole, 3>;

std::array<Exact, 5> exact(const std::array<Vec3, 5>& x) {
  constexpr int bits = 53;
  int least = 0;
  for (const Vec3& p : x)
    for (const double number : p) least = std::min(least, std::ilogb(number == 0 ? 1 : number) - bits);
  std::array<Exact, 5> out;
  for (std::size_t k = 0; k < 5; ++k)
    for (std::size_t c = 0; c < 3; ++c) {
      int exponent = 0;
      const double part = std::frexp(x[k][Index(c)], &exponent);
      if (part != 0) out[k][c] = Whole(std::int64_t(std::ldexp(part, bits))) << (exponent - bits - least);
    }
  return out;
}
Exact minus(const Exact& a, const Exact& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Whole dot(const Exact& a, const Exact& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Exact cross(const Exact& a, const Exact& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

struct Part {
  Whole above, below;  ///< below > 0
  Part(const Whole& over, const Whole& under) : above(under < 0 ? -over : over), below(abs(under)) {}
  bool operator<(const Part& other) const { return above * other.below < other.above * below; }
};

/// The segment is cut with the plane and the point tested in the triangle, or clipped at the triangle's edges where it lies in the plane.
bool meets(const std::array<Vec3, 5>& x) {
  const auto [p, q, t0, t1, t2] = exact(x);
  const Exact* const t[] = {&t0, &t1, &t2};
  const Exact n = cross(minus(t1, t0), minus(t2, t0)), d = minus(q, p);
  const Whole height = dot(n, minus(p, t0)), rate = dot(n, d);
  Part low(0, 1), high(1, 1);
  if (rate == 0) {
    if (height != 0) return false;
  } else {
    low = high = Part(-height, rate);
    if (low.above < 0 || low.above > low.below) return false;
  }
  for (int i = 0; i < 3; ++i) {  // inside: in . (p + s d - t_i) >= 0
    const Exact in = cross(n, minus(*t[(i + 1) % 3], *t[i]));
    const Whole at = dot(in, minus(p, *t[i])), slope = dot(in, d);
    if (slope == 0) {
      if (at < 0) return false;
    } else if (slope > 0) {
      low = std::max(low, Part(-at, slope));
    } else {
      high = std::min(high, Part(-at, slope));
    }
  }
  return !(high < low);
}
bool flat(const std::array<Vec3, 5>& x) {
  const std::array<Exact, 5> at = exact(x);
  const Exact n = cross(minus(at[3], at[2]), minus(at[4], at[2]));
  return n[0] == 0 && n[1] == 0 && n[2] == 0;
}

class Pairs {
 public:
  /// As std::uniform_real_distribution makes it, which takes logarithms for each number without optimisation.
  double number() {
    const double low = double(random_()), high = double(random_());
    return (low + high * 0x1p32) / 0x1p64 * 2 - 1;
  }
  Vec3 point() { return {number(), number(), number()}; }
  /// Coordinates of a coarse lattice: most determinants of such points vanish often.
  Vec3 corner(int count) {
    std::uniform_int_distribution<int> cell(0, count);
    return {double(cell(random_)), double(cell(random_)), double(cell(random_))};
  }

 private:
  std::mt19937 random_{3};
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
    // exact numbers take their time: every pair that is near a decision, and some of the others
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
