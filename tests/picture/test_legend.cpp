// SPDX-License-Identifier: LGPL-2.1-or-later
// Numbers of the legend: round, told apart, in a unit that suits them.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

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

TEST(Legends, NumbersThatHaveMuchInCommonAreToldApart) {
  EXPECT_EQ(alike({0.9999, 1, 1.0001}), (std::vector<std::string>{"0.9999", "1.0000", "1.0001"}));
  EXPECT_EQ(alike({20, 20.001, 20.002}), (std::vector<std::string>{"20.000", "20.001", "20.002"}));
  EXPECT_EQ(alike({20, 20 + 1e-7}), (std::vector<std::string>{"20.0000000", "20.0000001"}));
  EXPECT_EQ(alike({0, 1e-7}), (std::vector<std::string>{"0e+00", "1e-07"}));
  EXPECT_EQ(alike({101325, 101326}), (std::vector<std::string>{"1.01325e+05", "1.01326e+05"}));
  EXPECT_EQ(alike({0.1 + 0.2, 0.3}), (std::vector<std::string>{"0.3", "0.3"}));  // the same but for round-off
}

TEST(Legends, MarksOfNarrowRangesAreFewAndToldApart) {
  const ColourMap map("viridis");
  const FieldWord word{"J", "volume ratio J", "-"};
  const auto legend = [&](double low, double high) { return Legend(map, {low, high}, {low, high}, word, ""); };
  for (const double width : {2e-4, 1e-6, 1e-8}) {
    const std::vector<std::string> texts = legend(1 - width / 2, 1 + width / 2).texts();
    EXPECT_GE(texts.size(), 3u) << width;
    EXPECT_LE(texts.size(), 8u) << width;
    EXPECT_EQ(std::set<std::string>(texts.begin(), texts.end()).size(), texts.size()) << width;
  }
  EXPECT_EQ(legend(0.9999, 1.0001).summary(), "volume ratio J 0.9999 to 1.0001");
  EXPECT_EQ(legend(0, 2.5).summary(), "volume ratio J 0 to 2.5");
  EXPECT_LE(legend(1, 1.0000000000000002).texts().size(), 8u);  // it ends
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
