// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "framework/algebra/vector.h"

namespace stroma {

/// largest(), several numbers at once: the same number.
inline double largestNumber(ConstRows a) {
  using Eight = Eigen::Array<double, 8, 1>;
  static_assert(row_doubles == 4);
  const std::size_t count = a.doubles(), whole = count - count % 8;
  Eight most = Eight::Zero();
  for (std::size_t i = 0; i < whole; i += 8) most = most.max(Eigen::Map<const Eight>(a.data + i).abs());
  double value = most.maxCoeff();
  for (std::size_t i = whole; i < count; ++i) value = std::max(value, std::abs(a.data[i]));
  return value;
}

}  // namespace stroma
