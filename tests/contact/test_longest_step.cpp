// SPDX-License-Identifier: LGPL-2.1-or-later
// Longest steps: what meets is never missed, what is free is seldom stopped. Whether a pair meets on its way is known by
// construction: two points of it are led through each other at a time that is chosen.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "components/contact/longest_step.h"
#include "framework/collision/exact_intersection.h"
#include "tests/contact/every_pair.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

constexpr PairKind kinds[] = {PairKind::point_triangle, PairKind::edge_edge};

TEST(LongestStep, MissesNothingThatMeets) {
  Motions motions(1);
  double lost = 0;
  int far = 0;
  for (int i = 0; i < 100000; ++i)
    for (const PairKind kind : kinds) {
      FourPoints x, dx;
      const double when = motions.number(0.001, 1);
      motions.meeting(kind, when, 0, 1, x, dx);
      const double t = longestStep(kind, x, dx, {.left = 1e-3});
      ASSERT_LE(t, when * (1 + 1e-9)) << "missed";
      ASSERT_LT(t, 1) << "missed";
      lost += when - t;
      far += when - t > 0.1 * when;
    }
  RecordProperty("mean part of the step that is lost", std::to_string(lost / 2e5));
  EXPECT_LT(lost / 2e5, 0.02);
  EXPECT_LT(far, 20000) << "pairs may meet before as well, but few do";
}

TEST(LongestStep, MissesNoDegeneratePair) {
  Motions motions(2);
  for (int i = 0; i < 64000; ++i)
    for (const PairKind kind : kinds) {
      FourPoints x, dx;
      const double when = motions.number(0.001, 1), scale = std::pow(10, motions.number(-60, 60));
      motions.meeting(kind, when, i % 64, scale, x, dx);
      for (const double left : {0.1, 1e-6}) {
        const double t = longestStep(kind, x, dx, {.left = left});
        ASSERT_LE(t, when * (1 + 1e-9) + 1e-9) << "missed, case " << i % 64;
        ASSERT_TRUE(t < 1 || when > 1 - 1e-9) << "missed, case " << i % 64;
      }
    }
}

TEST(LongestStep, StopsFewThatAreFree) {
  Motions motions(3);
  int stopped = 0, free = 0, slow = 0;
  for (int i = 0; i < 20000; ++i)
    for (const PairKind kind : kinds) {
      const FourPoints x = motions.four(), dx = motions.four();
      const double least = smallestDistance(kind, x, dx, 1), start = closestPoints(kind, x).distance();
      const double t = longestStep(kind, x, dx, {.left = 1e-3});
      if (least < 0.02) continue;  // may meet between the samples
      ++free;
      stopped += t < 1;
      slow += longestStep(kind, x, dx) < 1 && least > 0.11 * start;
    }
  EXPECT_GT(free, 20000);
  EXPECT_EQ(stopped, 0);
  EXPECT_EQ(slow, 0) << "a step is shortened only where less than a tenth of the distance would be left";
}

/// What slides along a face at a millionth of its motion is free, in a few advances.
TEST(LongestStep, DoesNotTireOfSliding) {
  const FourPoints x{Vec3(0.3, 0.3, 1e-6), Vec3(0, 0, 0), Vec3(1e4, 0, 0), Vec3(0, 1e4, 0)};
  const FourPoints dx{Vec3(1e3, 1e3, 0), Vec3(0, 0, 0), Vec3(0, 0, 0), Vec3(0, 0, 0)};
  EXPECT_EQ(longestStep(PairKind::point_triangle, x, dx), 1);
}

/// Two long edges that cross at a small angle, or a point over a triangle, at a hundred-millionth of their size. Both turn about a line
/// through the place where they are nearest, as one body does: each point moves to the other side of where the normal has its plane,
/// but they never meet. They do where they also approach each other.
TEST(LongestStep, DoesNotTireOfSidesThatTiltTogether) {
  constexpr double gap = 1e-8;
  for (const PairKind kind : kinds)
    for (const double angle : {1e-3, 0.1, 1.0})
      for (const double closing : {0.0, 0.9, 1.6}) {  // of the gap, in the whole step
        FourPoints x{Vec3(0.1, 0.1, gap), Vec3(-1, -1, 0), Vec3(1, -1, 0), Vec3(0, 1, 0)};
        if (kind == PairKind::edge_edge) x = {Vec3(-1, 0, gap), Vec3(1, 0, gap), Vec3(-1, -angle, 0), Vec3(1, angle, 0)};
        FourPoints dx;
        for (std::size_t i = 0; i < 4; ++i) dx[i] = 5e-3 * Vec3(0.3, 1, 0).cross(x[i]);
        for (std::size_t i = 0; i < (kind == PairKind::edge_edge ? 2 : 1); ++i) dx[i].z() -= closing * gap;
        const double t = longestStep(kind, x, dx);
        SCOPED_TRACE(fmt::format("{}, angle {}, closing {}", kind == PairKind::edge_edge ? "edges" : "triangle", angle, closing));
        if (closing < 1) {
          EXPECT_EQ(t, 1);
        } else {
          EXPECT_LT(t, 1 / closing * (1 + 1e-4));
          EXPECT_GT(t, 0.8 / closing);
        }
      }
}

/// Small pairs a million metres from the origin, whose places are rounded to 1e-10 m: a point over a triangle and an edge over an edge,
/// a few of these steps apart. Where they end is rounded too, and they are on the sides where they were, exactly.
TEST(LongestStep, PlacesThatAreRoundedHaveNotMet) {
  Motions motions(4);
  const double step = std::ldexp(1, -33);  // of doubles up to 2^20
  int moved = 0;
  for (int i = 0; i < 20000; ++i)
    for (const PairKind kind : kinds) {
      const Vec3 far = 5e5 * motions.point() + Vec3::Constant(5.2e5);
      const double gap = step * std::floor(motions.number(1, 40));
      FourPoints x{Vec3(0.3, 0.3, gap), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
      if (kind == PairKind::edge_edge) x = {Vec3(-1, 0, gap), Vec3(1, 0, gap), Vec3(0, -1, 0), Vec3(0, 1, 0)};
      FourPoints dx, end;
      const Vec3 together = 0.1 * motions.point();
      for (std::size_t k = 0; k < 4; ++k) {
        x[k] = 1e-3 * Vec3(x[k].x(), x[k].y(), 0) + Vec3(0, 0, x[k].z()) + far;
        dx[k] = together + 10 * gap * motions.point();
      }
      const auto side = [kind](const FourPoints& p) {
        return kind == PairKind::edge_edge ? orientation(p[0], p[1], p[2], p[3]) : orientation(p[1], p[2], p[3], p[0]);
      };
      const double t = longestStep(kind, x, dx);
      for (std::size_t k = 0; k < 4; ++k) end[k] = x[k] + t * dx[k];
      ASSERT_NE(side(x), 0) << i;
      ASSERT_EQ(side(end), side(x)) << i << ", a gap of " << gap / step << " steps";
      moved += t > 0;
    }
  EXPECT_GT(moved, 10000);
}

TEST(LongestStep, OfPairsThatTouchOrStandOrAreNoNumbers) {
  const Vec3 o = Vec3::Zero(), e(1, 0, 0), f(0, 1, 0), g(0, 0, 1);
  const FourPoints still{o, o, o, o}, down{Vec3(-g), o, o, o};
  EXPECT_EQ(longestStep(PairKind::point_triangle, {Vec3(0.2 * e + 0.2 * f), o, e, f}, down), 0);
  EXPECT_EQ(longestStep(PairKind::point_triangle, {Vec3(0.2 * e + 0.2 * f), o, e, f}, still), 0) << "it touches already";
  EXPECT_EQ(longestStep(PairKind::point_triangle, {Vec3(0.2 * e + 0.2 * f + g), o, e, f}, still), 1);
  EXPECT_EQ(longestStep(PairKind::edge_edge, {o, o, o, o}, {g, o, o, o}), 0);
  EXPECT_EQ(longestStep(PairKind::point_triangle, {g, o, e, f}, {Vec3::Constant(std::nan("")), o, o, o}), 0);
  const double t = longestStep(PairKind::point_triangle, {Vec3(0.2 * e + 0.2 * f + g), o, e, f},
                               {Vec3(-2 * g), o, o, o}, {.thickness = 0.5});
  EXPECT_LT(t, 0.25);
  EXPECT_GT(t, 0.22);
  EXPECT_NEAR(longestStepToPlane(1, 2), 0.45, 1e-12);
  EXPECT_EQ(longestStepToPlane(1, -2), 1);
  EXPECT_EQ(longestStepToPlane(0, 2), 0);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
