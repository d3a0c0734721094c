// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/algebra/vector.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// The size whatever the sign and the place, also of numbers that are denormal or infinite; what is no number is not lost.
TEST(Vector, TheLargestComponentIsFoundWhereverItStands) {
  constexpr double tiny = std::numeric_limits<double>::denorm_min(), infinity = std::numeric_limits<double>::infinity();
  for (Index rows = 1; rows < 12; ++rows)
    for (Index at = 0; at < rows; ++at)
      for (int c = 0; c < 3; ++c) {
        Vector v(rows);
        clear(v);
        EXPECT_EQ(largest(v), 0);
        for (const double value : {tiny, 2., -3., 1e300, -infinity}) {
          v[at][c] = value;
          EXPECT_EQ(largest(v), std::abs(value)) << rows << " " << at << " " << c;
        }
        for (const double sign : {1., -1.}) {
          v[at][c] = std::copysign(std::numeric_limits<double>::quiet_NaN(), sign);
          v[(at + 1) % rows][(c + 1) % 3] = infinity;
          EXPECT_TRUE(std::isnan(largest(v)));
        }
      }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
