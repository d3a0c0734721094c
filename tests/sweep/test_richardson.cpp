// SPDX-License-Identifier: LGPL-2.1-or-later
// Orders and limits from values whose order and limit are known.
#include <gtest/gtest.h>

#include <cmath>

#include "tools/sweep/richardson.h"

namespace stroma::sweep {
namespace {

TEST(Richardson, FindsOrderAndLimitForAnySizes) {
  for (const double p : {0.5, 1.0, 2.0, 3.3}) {
    const double s1 = 0.1, s2 = 0.17, s3 = 0.4;
    const auto value = [&](double s) { return 7 - 2.5 * std::pow(s, p); };
    const auto order = fittedOrder(s1, s2, s3, std::abs(value(s2) - value(s1)), std::abs(value(s3) - value(s2)));
    ASSERT_TRUE(order) << p;
    EXPECT_NEAR(*order, p, 1e-9);
    EXPECT_NEAR(value(s1) + correctionFactor(s1, s2, *order) * (value(s1) - value(s2)), 7, 1e-9) << p;
  }
}

TEST(Richardson, HasNoOrderWhereDifferencesFollowNone) {
  EXPECT_FALSE(fittedOrder(0.1, 0.2, 0.4, 1, 0.5)) << "the differences grow towards the fine end";
  EXPECT_FALSE(fittedOrder(0.1, 0.2, 0.4, 0, 1));
  EXPECT_FALSE(fittedOrder(0.1, 0.1, 0.4, 1, 2)) << "the same size twice";
  EXPECT_FALSE(fittedOrder(0.1, 0.2, 0.4, 1, 1e9)) << "no order is so high";
}

TEST(Richardson, SlopeIsThatOfThePower) {
  const std::vector<double> sizes{0.1, 0.2, 0.3, 0.8};
  std::vector<double> errors;
  for (const double size : sizes) errors.push_back(4 * std::pow(size, 1.7));
  EXPECT_NEAR(*slopeOf(sizes, errors), 1.7, 1e-12);
  EXPECT_FALSE(slopeOf({0.1}, {1}));
  EXPECT_FALSE(slopeOf({0.1, 0.2}, {1, 0})) << "an error of zero has no logarithm";
}

}  // namespace
}  // namespace stroma::sweep
