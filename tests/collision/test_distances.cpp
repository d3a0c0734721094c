// SPDX-License-Identifier: LGPL-2.1-or-later
// The tree of boxes against looking at all of them, distances against points laid over both things.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "components/collision/distances.h"
#include "framework/collision/box_tree.h"

namespace stroma {
namespace STROMA_TEST_FILE {

Vec3 somewhere(std::mt19937& random) {
  std::uniform_real_distribution<double> place(-1, 1);
  return {place(random), place(random), place(random)};
}

std::vector<Box> someBoxes(std::mt19937& random, int count) {
  std::vector<Box> boxes(static_cast<std::size_t>(count));
  for (Box& box : boxes) {
    const Vec3 p = somewhere(random);
    box.add(p);
    box.add(Vec3(p + 0.2 * somewhere(random)));
  }
  return boxes;
}

TEST(BoxTree, FindsWhatMeetsABoxAndNothingElse) {
  std::mt19937 random(1);
  for (const int count : {1, 2, 3, 50, 333}) {
    std::vector<Box> boxes = someBoxes(random, count);
    BoxTree tree;
    tree.build(boxes);
    for (int round = 0; round < 20; ++round) {
      if (round == 10) tree.refit(boxes = someBoxes(random, count));
      const Box asked = someBoxes(random, 1)[0].grownBy(0.1);
      std::set<Index> found, expected;
      tree.forEachMeeting(asked, [&](Index i) { EXPECT_TRUE(found.insert(i).second); });
      for (Index i = 0; i < count; ++i)
        if (boxes[std::size_t(i)].meets(asked)) expected.insert(i);
      EXPECT_EQ(found, expected);
    }
  }
}

/// Each pair once, of two trees and of a tree with itself, also after motion.
TEST(BoxTree, FindsEachPairOnce) {
  using Found = std::multiset<std::pair<Index, Index>>;
  std::mt19937 random(4);
  for (const int count : {0, 1, 2, 5, 300}) {
    std::vector<Box> a = someBoxes(random, count);
    const std::vector<Box> b = someBoxes(random, 200);
    BoxTree first, second;
    first.build(a), second.build(b);
    for (const double margin : {0., 0.03}) {
      Found between, within, all, two;
      first.forEachPair(second, margin, [&](Index i, Index j) { between.emplace(i, j); });
      first.forEachPair(first, margin, [&](Index i, Index j) { within.emplace(std::min(i, j), std::max(i, j)); });
      for (Index i = 0; i < count; ++i) {
        for (Index j = 0; j < 200; ++j)
          if (a[std::size_t(i)].grownBy(margin).meets(b[std::size_t(j)])) all.emplace(i, j);
        for (Index j = i + 1; j < count; ++j)
          if (a[std::size_t(i)].grownBy(margin).meets(a[std::size_t(j)])) two.emplace(i, j);
      }
      EXPECT_EQ(between, all);
      EXPECT_EQ(within, two);
      first.refit(a = someBoxes(random, count));
    }
  }
}

/// Points of a thing of up to three corners, a fine net.
std::vector<Vec3> laidOver(const std::vector<Vec3>& corners) {
  std::vector<Vec3> points;
  constexpr int n = 60;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= (corners.size() == 3 ? n - i : 0); ++j) {
      Vec3 p = corners[0];
      if (corners.size() > 1) p += (corners[1] - corners[0]) * i / n;
      if (corners.size() > 2) p += (corners[2] - corners[0]) * j / n;
      points.push_back(p);
    }
  return points;
}

/// Over numbers, not matrices: tests are compiled without optimisation.
double leastBetween(const std::vector<Vec3>& first, const std::vector<Vec3>& second) {
  const double* const p = first[0].data();
  const double* const q = second[0].data();
  const std::size_t ends[] = {3 * first.size(), 3 * second.size()};
  double least = 1e60;
  for (std::size_t i = 0; i < ends[0]; i += 3)
    for (std::size_t j = 0; j < ends[1]; j += 3) {
      const double x = p[i] - q[j], y = p[i + 1] - q[j + 1], z = p[i + 2] - q[j + 2];
      const double squared = x * x + y * y + z * z;
      if (squared < least) least = squared;
    }
  return std::sqrt(least);
}

TEST(Distances, AreThoseOfTheNearestPoints) {
  std::mt19937 random(3);
  for (std::size_t a = 1; a <= 3; ++a)
    for (std::size_t b = a; b <= 3; ++b)
      for (int round = 0; round < 8; ++round) {
        std::vector<Vec3> first(a), second(b);
        for (Vec3& p : first) p = somewhere(random);
        for (Vec3& p : second) p = somewhere(random);
        const double least = leastBetween(laidOver(first), laidOver(second));
        const double found = distanceOf(first, second);
        EXPECT_LE(found, least + 1e-12);
        EXPECT_GE(found, least - 0.08) << a << " and " << b << " corners";
        EXPECT_NEAR(found, distanceOf(second, first), 1e-14);
      }
}

TEST(Distances, OfThingsThatCrossAreZero) {
  const std::vector<Vec3> flat{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, line{{0.2, 0.2, -1}, {0.2, 0.2, 1}},
      beside{{0.8, 0.8, -1}, {0.8, 0.8, 1}}, upright{{0.2, 0.2, -1}, {0.2, 0.2, 1}, {2, 2, 0.1}};
  EXPECT_EQ(distanceOf(flat, line), 0);
  EXPECT_EQ(distanceOf(flat, upright), 0);
  EXPECT_NEAR(distanceOf(flat, beside), 0.6 / std::sqrt(2), 1e-12);
  EXPECT_EQ(distanceOf(std::vector<Vec3>{{0, 0, 3}}, flat), 3);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma
