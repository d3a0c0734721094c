// SPDX-License-Identifier: LGPL-2.1-or-later
// When a step of BarrierContact is solved again because its shares of the surface have changed.
#include <gtest/gtest.h>

#include <cmath>

#include "components/contact/line_shares.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// How many solves follow the first one.
template <class Change>
int repeated(const Change& change) {
  contact::ShareRounds rounds;
  rounds.stepBegins();
  int solves = 0;
  while (rounds.goOn(change(solves))) ++solves;
  EXPECT_EQ(rounds.left(), change(solves));
  return solves;
}

TEST(ShareRounds, ASwingEndsAndWhatGetsSmallerSlowlyGoesOn) {
  EXPECT_EQ(repeated([](int) { return 0.2; }), 2);
  EXPECT_EQ(repeated([](int k) { return k % 2 == 0 ? 0.3 : 0.05; }), 2) << "between two states";
  EXPECT_EQ(repeated([](int k) { return 0.02 * std::pow(0.92, k); }), 9);
  EXPECT_EQ(repeated([](int k) { return 0.02 * std::pow(0.4, k); }), 1);
  EXPECT_EQ(repeated([](int) { return 0.009; }), 0) << "settled";
}

/// Forces that follow shares where a solve is repeated only swing with them.
TEST(ShareRounds, SharesFollowTheFirstSolveAndStayInThoseThatRepeatIt) {
  contact::LineShares shares;
  std::vector<Vec3> x{Vec3::Zero()};
  shares.solveBegins();
  EXPECT_EQ(shares.placeFor(x), &x);
  shares.solveBegins(true);
  EXPECT_EQ(shares.placeFor(x), nullptr);
  shares.solveBegins();
  EXPECT_EQ(shares.placeFor(x), &x);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
