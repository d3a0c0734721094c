// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <random>
#include <set>

#include "components/contact/box_hierarchy.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

using contact::Box;
using contact::Hierarchy;

std::vector<Box> randomBoxes(std::size_t count, unsigned seed, double size) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<Box> boxes(count);
  for (Box& box : boxes) {
    const Vec3 p(uniform(random), uniform(random), uniform(random));
    box.add(p);
    box.add(p + size * Vec3(uniform(random), uniform(random), uniform(random)));
  }
  return boxes;
}

using Found = std::multiset<std::pair<int, int>>;
Found all(const std::vector<Box>& a, const std::vector<Box>& b, double margin, bool same) {
  Found found;
  for (int i = 0; i < int(a.size()); ++i)
    for (int j = same ? i + 1 : 0; j < int(b.size()); ++j)
      if (a[std::size_t(i)].meets(b[std::size_t(j)], margin)) found.emplace(i, j);
  return found;
}

TEST(Hierarchy, FindsEachPairOnceAlsoAfterMotion) {
  for (const std::size_t count : {0u, 1u, 5u, 300u}) {
    const auto a = randomBoxes(count, 1, 0.1), b = randomBoxes(200, 2, 0.05), moved = randomBoxes(count, 3, 0.2);
    Hierarchy first, second;
    first.build(a), second.build(b);
    const auto between = [&](double margin) {
      Found found;
      Hierarchy::pairs(first, second, margin, [&](int i, int j) { found.emplace(i, j); });
      return found;
    };
    const auto within = [&] {
      Found found;
      Hierarchy::pairs(first, first, 0.01, [&](int i, int j) { found.emplace(std::min(i, j), std::max(i, j)); });
      return found;
    };
    EXPECT_EQ(between(0.02), all(a, b, 0.02, false));
    EXPECT_EQ(within(), all(a, a, 0.01, true));
    first.refit(moved);
    EXPECT_EQ(between(0), all(moved, b, 0, false));
    EXPECT_EQ(within(), all(moved, moved, 0.01, true));
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
