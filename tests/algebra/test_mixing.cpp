// SPDX-License-Identifier: LGPL-2.1-or-later
// Mixed iterates of fixed points that iterates alone do not reach, or creep to.
#include <gtest/gtest.h>

#include <cmath>

#include "framework/algebra/mixing.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// z = centre + rates (z - centre), and a little of the square.
struct Spring {
  std::vector<double> rates;
  double bend = 0;
  void image(ConstRows z, Rows out) const {
    for (std::size_t i = 0; i < rates.size(); ++i) {
      const double off = z.data[i] - double(i + 1);
      out.data[i] = double(i + 1) + rates[i] * off + bend * off * off;
    }
  }
};

/// Iterations until |F(z) - z| is 1e-10; at most `most`.
int iterations(const Spring& spring, int most, Mixing* mixing) {
  Vector z, image;
  const auto rows = Index((spring.rates.size() + row_doubles - 1) / row_doubles);
  z.resize(rows), image.resize(rows);
  clear(z), clear(image);
  for (int k = 1; k <= most; ++k) {
    spring.image(z, image);
    if (distance(z, image) <= 1e-10) return k;
    if (mixing) mixing->next(z, image);
    copy(image, z);
  }
  return most + 1;
}

TEST(Mixing, WhatCreepsComesToRest) {
  const Spring creeping{{0.992, 0.3, -0.5, 0.1}};
  EXPECT_GT(iterations(creeping, 2000, nullptr), 2000);
  Mixing mixing;
  EXPECT_LE(iterations(creeping, 100, &mixing), 20);
}

TEST(Mixing, WhatSwingsOrRunsAwayComesToRest) {
  for (const double rate : {-0.98, -1.5, 1.3, 0.9995}) {
    Mixing mixing;
    EXPECT_LE(iterations({{rate, 0.9, 0.3, -0.5, 0.1, 0.02, 0, 0.6}}, 100, &mixing), 25) << rate;
  }
}

/// Far from linear: large weights lead astray, and it goes on from the best.
TEST(Mixing, WhatBendsComesToRest) {
  for (const double bend : {-0.02, 0.004, 0.05}) {
    Mixing mixing;
    EXPECT_LE(iterations({{0.97, 0.5, -0.4, 0.2}, bend}, 200, &mixing), 60) << bend;
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
