// SPDX-License-Identifier: LGPL-2.1-or-later
// Numbers of the legend: round, told apart, in a unit that suits them.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tools/picture/legend.h"

namespace stroma::picture {
namespace {

TEST(Legends, StepsAreRoundAndFit) {
  EXPECT_DOUBLE_EQ(roundStep(7, 7), 1);
  EXPECT_DOUBLE_EQ(roundStep(7.1, 7), 2);
  EXPECT_DOUBLE_EQ(roundStep(1, 5), 0.2);
  EXPECT_DOUBLE_EQ(roundStep(1700, 7), 250);
  EXPECT_DOUBLE_EQ(roundStep(60, 7), 10);
}

TEST(Legends, RoundedRangesHoldTheRangeAndAreNotMuchWider) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> number(-1, 1), power(-6, 9);
  for (int i = 0; i < 1000; ++i) {
    const double size = std::pow(10, power(random)), a = size * number(random), b = size * number(random);
    const Range range{std::min(a, b), std::max(a, b)}, out = rounded(range);
    const double span = range.high - range.low;
    EXPECT_LE(out.low, range.low + 1e-5 * span);
    EXPECT_GE(out.high, range.high - 1e-5 * span);
    EXPECT_LE(out.high - out.low, 2.5 * span) << range.low << ' ' << range.high;
  }
}

TEST(Legends, ARangeOfOneValueGetsARoom) {
  EXPECT_LT(rounded({2, 2}).low, 2);
  EXPECT_GT(rounded({2, 2}).high, 2);
  const Range zero = rounded({0, 0});
  EXPECT_EQ(zero.low, 0);
  EXPECT_EQ(zero.high, 1);
  const Range nothing = rounded({std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()});
  EXPECT_LT(nothing.low, nothing.high);
}

TEST(Legends, NumbersHaveTheDecimalsThatTellThemApart) {
  EXPECT_EQ(alike({0, 0.5, 1}), (std::vector<std::string>{"0.0", "0.5", "1.0"}));
  EXPECT_EQ(alike({0, 250, 500}), (std::vector<std::string>{"0", "250", "500"}));
  EXPECT_EQ(alike({-0.25, 0, 0.25}), (std::vector<std::string>{"-0.25", "0.00", "0.25"}));
  EXPECT_EQ(alike({0, 2e-5}), (std::vector<std::string>{"0e+00", "2e-05"}));
}

TEST(Legends, UnitsSuitTheSize) {
  EXPECT_EQ(scaleFor(2500, "Pa").unit, "kPa");
  EXPECT_DOUBLE_EQ(scaleFor(2500, "Pa").factor, 1e3);
  EXPECT_EQ(scaleFor(0.02, "m").unit, "mm");
  EXPECT_EQ(scaleFor(2000, "m").unit, "m");
  EXPECT_EQ(scaleFor(0.02, "m/s").unit, "mm/s");
  EXPECT_EQ(scaleFor(3e-5, "m").unit, "µm");
  EXPECT_EQ(scaleFor(3e6, "Pa").unit, "MPa");
  EXPECT_EQ(scaleFor(0.5, "-").unit, "");
  EXPECT_EQ(scaleFor(0.5, "-").factor, 1);
}

}  // namespace
}  // namespace stroma::picture
