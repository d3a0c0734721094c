// SPDX-License-Identifier: LGPL-2.1-or-later
// A million motions that meet, without error: points, weights and velocities are whole multiples of powers of two, so that
// the place and the time where two points of a pair come together are exact numbers. Distances against rational numbers.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "framework/collision/exact_intersection.h"
#include "components/contact/contact_parts.h"
#include "components/contact/longest_step.h"
#include "tests/contact/exact_pairs.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

using namespace exact_pairs;

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

/// Parallel edges, slivers, edges without length, triangles without area, meetings at corners and on edges; as they are, a millionth and a
/// million times as large, and a million metres from the origin. They touch exactly where the step ends: that is missed by none. Where
/// they stop, as doubles round it, nothing has met. What touches exactly where the step starts does not move, apart or nearer.
TEST(Queries, WhatTouchesAtTheEndOrAtTheStart) {
  Numbers numbers(19);
  struct Place {
    int power;
    double offset;
  };
  int moved = 0;
  for (const Place& place : {Place{0, 0}, Place{-20, 0}, Place{20, 0}, Place{0, 0x1p10}, Place{0, 0x1p20}})
    for (unsigned i = 0; i < 1280; ++i)
      for (const PairKind kind : {PairKind::point_triangle, PairKind::edge_edge}) {
        if (place.offset > 0 && (i & 16)) continue;  // these have too many digits
        FourPoints x, dx, start, way, at, end;
        double when;
        makeMeeting(numbers, kind, i % 64, when, x, dx);
        const double size = std::ldexp(1, place.power);
        for (std::size_t k = 0; k < 4; ++k) {
          at[k] = size * (x[k] + when * dx[k]) + place.offset * Vec3(1, -1, 0.5);
          way[k] = size * when * dx[k], start[k] = at[k] - way[k];
        }
        ASSERT_EQ(squaredDistance(kind, exact(at)), 0) << i;
        const double t = longestStep(kind, start, way);
        ASSERT_LT(t, 1) << "missed pair " << i << " at 2^" << place.power << ", " << place.offset;
        for (std::size_t k = 0; k < 4; ++k) end[k] = start[k] + t * way[k];
        if (t > 0) ASSERT_GT(squaredDistance(kind, exact(end)), 0) << i;
        moved += t > 0;
        ASSERT_EQ(longestStep(kind, at, way), 0) << "it touches where it starts, " << i;
      }
  EXPECT_GT(moved, 5000);
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

/// Pairs that lie still, or go along together, move nothing towards each other; what touches has touched from the start.
TEST(Queries, WhatTouchesAndGoesAlongTogetherTouches) {
  Numbers numbers(17);
  int touching = 0;
  for (int i = 0; i < 3000; ++i)
    for (const PairKind kind : {PairKind::point_triangle, PairKind::edge_edge}) {
      FourPoints x, way;
      for (Vec3& p : x) p = Vec3(numbers.whole(-2, 2), numbers.whole(-2, 2), numbers.whole(-2, 2));
      const Vec3 together = i % 2 == 0 ? Vec3(0, 0, 0) : Vec3(numbers.whole(-2, 2), numbers.whole(-2, 2), 1);
      way.fill(together);
      const bool touches = squaredDistance(kind, exact(x)) == 0;
      ASSERT_EQ(longestStep(kind, x, way), touches ? 0 : 1) << i;
      touching += touches;
    }
  EXPECT_GT(touching, 100);
}

/// Products of four lengths leave the range of doubles from 1e-81 and from 1e77 on.
TEST(Queries, DistancesOfVeryLargeAndVerySmallPairs) {
  Numbers numbers(18);
  for (int i = 0; i < 300; ++i)
    for (const int power : {-1000, -500, -300, -250, 0, 250, 300, 500, 1000})
      for (const PairKind kind : {PairKind::point_triangle, PairKind::edge_edge}) {
        FourPoints x, large;
        for (Vec3& p : x) p = Vec3(numbers.whole(-2, 2), numbers.whole(-2, 2), numbers.whole(-2, 2));
        for (std::size_t k = 0; k < 4; ++k) large[k] = std::ldexp(1, power) * x[k];
        const Vec3 found = closestPoints(kind, large).difference / std::ldexp(1, power);
        ASSERT_NEAR(found.norm(), std::sqrt(double(squaredDistance(kind, exact(x)))), 1e-15 * 16) << i << ' ' << power;
      }
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
