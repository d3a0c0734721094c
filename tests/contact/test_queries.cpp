// SPDX-License-Identifier: LGPL-2.1-or-later
// A million motions that meet, without error: points, weights and velocities are whole multiples of powers of two, so that
// the place and the time where two points of a pair come together are exact numbers. Distances against rational numbers.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <random>

#include "framework/collision/exact_intersection.h"
#include "components/contact/contact_parts.h"
#include "components/contact/longest_step.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

using Rational = boost::multiprecision::cpp_rational;
using Exact = std::array<Rational, 3>;

Exact exact(const Vec3& p) { return {Rational(p.x()), Rational(p.y()), Rational(p.z())}; }
Exact operator-(const Exact& a, const Exact& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Exact operator+(const Exact& a, const Exact& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Exact operator*(const Rational& s, const Exact& a) { return {s * a[0], s * a[1], s * a[2]}; }
Rational dot(const Exact& a, const Exact& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Exact cross(const Exact& a, const Exact& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Rational square(const Exact& a) { return dot(a, a); }

/// Squared distance of a point from a segment, of two segments, of a point from a triangle.
Rational ofSegment(const Exact& p, const Exact& a, const Exact& b) {
  const Exact along = b - a;
  const Rational length = square(along);
  Rational t = length == 0 ? Rational(0) : Rational(dot(p - a, along) / length);
  t = t < 0 ? Rational(0) : t > 1 ? Rational(1) : t;
  return square(p - (a + t * along));
}
Rational ofSegments(const Exact& a, const Exact& b, const Exact& c, const Exact& d) {
  Rational best = std::min({ofSegment(a, c, d), ofSegment(b, c, d), ofSegment(c, a, b), ofSegment(d, a, b)});
  const Exact u = b - a, v = d - c, w = a - c, n = cross(u, v);
  const Rational size = square(n);
  if (size == 0) return best;
  const Rational s = dot(cross(v, w), n) / size, t = dot(cross(u, w), n) / size;
  if (s >= 0 && s <= 1 && t >= 0 && t <= 1) best = std::min(best, Rational(dot(w, n) * dot(w, n) / size));
  return best;
}
Rational ofTriangle(const Exact& p, const Exact& a, const Exact& b, const Exact& c) {
  Rational best = std::min({ofSegment(p, a, b), ofSegment(p, b, c), ofSegment(p, c, a)});
  const Exact n = cross(b - a, c - a);
  const Rational size = square(n);
  if (size == 0) return best;
  const auto side = [&](const Exact& q, const Exact& r) { return dot(cross(r - q, p - q), n); };
  if (side(a, b) >= 0 && side(b, c) >= 0 && side(c, a) >= 0)
    best = std::min(best, Rational(dot(p - a, n) * dot(p - a, n) / size));
  return best;
}
Rational squaredDistance(PairKind kind, const std::array<Exact, 4>& x) {
  return kind == PairKind::edge_edge ? ofSegments(x[0], x[1], x[2], x[3]) : ofTriangle(x[0], x[1], x[2], x[3]);
}
std::array<Exact, 4> exact(const FourPoints& x) { return {exact(x[0]), exact(x[1]), exact(x[2]), exact(x[3])}; }

class Numbers {
 public:
  explicit Numbers(unsigned seed) : random_(seed) {}
  int whole(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }
  /// Multiples of 2^-10 between -1 and 1.
  Vec3 point() { return Vec3(whole(-1024, 1024), whole(-1024, 1024), whole(-1024, 1024)) / 1024; }

 private:
  std::mt19937 random_;
};

/// x + when dx has a point of both sides in common, exactly. `degenerate`: bits, see below.
void makeMeeting(Numbers& numbers, PairKind kind, unsigned degenerate, double& when, FourPoints& x, FourPoints& dx) {
  FourPoints at{numbers.point(), numbers.point(), numbers.point(), numbers.point()};
  double u = numbers.whole(0, 64) / 64., w = numbers.whole(0, 64) / 64.;
  if (degenerate & 1) u = std::round(u);                                              // at a corner
  if (degenerate & 2) w = std::round(w);                                              // on an edge
  if (degenerate & 4) at[3] = at[2];                                                  // no length, no area
  if (degenerate & 8) at[1] = at[0] + (at[3] - at[2]);                                // parallel
  if (degenerate & 16) at[3] = at[2] + (at[2] - at[1]) + numbers.point() / (1 << 20);  // a sliver
  const bool edges = kind == PairKind::edge_edge;
  const Vec3 second = edges ? Vec3((1 - w) * at[2] + w * at[3])
                            : Vec3((1 - u) * at[1] + u * ((1 - w) * at[2] + w * at[3]));
  const Vec3 first = edges ? Vec3((1 - u) * at[0] + u * at[1]) : at[0];
  at[0] += second - first;
  if (edges) at[1] += second - first;
  when = numbers.whole(1, 1023) / 1024.;
  for (Vec3& way : dx) way = numbers.point() * std::ldexp(1, numbers.whole(-3, 3));
  if (degenerate & 32) dx[3] = dx[2] = dx[1] = edges ? dx[2] : dx[1];  // a side that does not turn
  for (std::size_t i = 0; i < 4; ++i) x[i] = at[i] - when * dx[i];
}

TEST(Queries, AMillionThatMeetAreAllFound) {
  Numbers numbers(11);
  double lost = 0;
  long far = 0;
  constexpr int count = 500000;
  for (int i = 0; i < count; ++i)
    for (const PairKind kind : {PairKind::point_triangle, PairKind::edge_edge}) {
      FourPoints x, dx;
      double when;
      makeMeeting(numbers, kind, 0, when, x, dx);
      const double t = longestStep(kind, x, dx, {.left = 0.01});
      ASSERT_LT(t, when) << "missed pair " << i;
      lost += (when - t) / when;
      far += when - t > 0.1 * when;
    }
  RecordProperty("mean part of the way that is lost", std::to_string(lost / (2 * count)));
  EXPECT_LT(lost / (2 * count), 0.06) << "pairs may meet before as well";
  EXPECT_LT(far, 2 * count / 8);
}

TEST(Queries, DegenerateOnesAreAllFound) {
  Numbers numbers(12);
  for (unsigned i = 0; i < 6400; ++i)
    for (const PairKind kind : {PairKind::point_triangle, PairKind::edge_edge})
      for (const double left : {0.1, 1e-6}) {
        FourPoints x, dx;
        double when;
        makeMeeting(numbers, kind, i % 64, when, x, dx);
        const double t = longestStep(kind, x, dx, {.left = left});
        ASSERT_TRUE(t < when) << "missed pair " << i << ", case " << i % 64;
        // and where it stops, in exact arithmetic, nothing has met
        if (i % 16 != 0 || t == 0) continue;
        std::array<Exact, 4> now;
        for (std::size_t k = 0; k < 4; ++k) now[k] = exact(x[k]) + Rational(t) * exact(dx[k]);
        ASSERT_GT(squaredDistance(kind, now), 0) << i;
      }
}

/// A side that is carried along as a whole can meet once only where the other is flat: what is lost has a bound.
TEST(Queries, LittleIsLostOfAStraightApproach) {
  Numbers numbers(13);
  double worst = 0;
  for (int i = 0; i < 20000; ++i) {
    const FourPoints x{Vec3(0.3, 0.3, numbers.whole(1, 1024) / 1024.), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
    const double way = x[0].z() * numbers.whole(65, 6400) / 64.;
    const FourPoints dx{Vec3(0, 0, -way), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
    const double meets = x[0].z() / way, t = longestStep(PairKind::point_triangle, x, dx);
    ASSERT_LT(t, meets);
    worst = std::max(worst, (meets - t) / meets);
  }
  EXPECT_LE(worst, 0.1 + 1e-6) << "a tenth of the distance is left, no more";
}

/// Coordinates of -2 to 2: half of these pairs are degenerate, flat, parallel, in one plane, in one line, or touch.
TEST(Queries, DistancesOfLatticePointsAgreeWithRationalNumbers) {
  Numbers numbers(15);
  int touching = 0;
  for (int i = 0; i < 15000; ++i)
    for (const PairKind kind : {PairKind::point_triangle, PairKind::edge_edge}) {
      FourPoints x;
      for (Vec3& p : x) p = Vec3(numbers.whole(-2, 2), numbers.whole(-2, 2), numbers.whole(-2, 2));
      const Rational square = squaredDistance(kind, exact(x));
      const double found = closestPoints(kind, x).distance();
      ASSERT_NEAR(found, std::sqrt(double(square)), 1e-15 * 16) << i;
      if (square != 0) continue;
      ++touching;
      FourPoints way{Vec3(1, 0, 0), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
      ASSERT_EQ(longestStep(kind, x, way), 0) << "what touches does not move on, " << i;
    }
  EXPECT_GT(touching, 500);
}

TEST(Queries, DistancesAgreeWithRationalNumbers) {
  Numbers numbers(14);
  for (unsigned i = 0; i < 3000; ++i)
    for (const PairKind kind : {PairKind::point_triangle, PairKind::edge_edge}) {
      FourPoints x, dx;
      double when;
      makeMeeting(numbers, kind, i % 64, when, x, dx);
      const double expected = std::sqrt(double(squaredDistance(kind, exact(x))));
      ASSERT_NEAR(closestPoints(kind, x).distance(), expected, 1e-14 * 16) << i;
    }
}

/// Edges that are nearly parallel, from exactly to a thousandth: side by side, over each other, in one line, crossing, touching. The
/// bound is no more than the distance, in rational numbers, and less by no more than their angle makes of half an edge.
TEST(Queries, TheBoundForParallelEdgesIsOne) {
  Numbers numbers(16);
  int bounds = 0, crossed = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 along = numbers.point();
    if (along.norm() < 0.1) continue;
    const double angle = numbers.whole(0, 8) == 0 ? 0 : std::ldexp(1, -numbers.whole(11, 56));
    const double length = numbers.whole(-64, 64) / 32., apart = numbers.whole(0, 2) == 0 ? 0 : std::ldexp(1, -numbers.whole(0, 50));
    FourPoints x{numbers.point(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
    x[1] = x[0] + along;
    x[2] = x[0] + numbers.whole(-64, 64) / 32. * along + apart * numbers.point();
    x[3] = x[2] + length * (along + angle * numbers.point());
    const double bound = contact::leastOfParallel(x);
    if (bound < 0) continue;
    ++bounds;
    const Rational square = squaredDistance(PairKind::edge_edge, exact(x));
    ASSERT_LE(Rational(bound) * Rational(bound), square) << i;
    const Vec3 p = x[1] - x[0], q = x[3] - x[2];
    const double slack = 0.51 * p.cross(q).norm() / std::max(p.norm(), q.norm());
    const double distance = std::sqrt(double(square));
    ASSERT_GE(bound, std::sqrt(std::max(0.0, distance * distance - slack * slack)) - 2e-13) << i;
    crossed += distance < 1e-12;
  }
  EXPECT_GT(bounds, 10000);
  EXPECT_GT(crossed, 100);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
