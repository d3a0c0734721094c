// SPDX-License-Identifier: LGPL-2.1-or-later
// Rows of a system for contracts: at random, and how far apart.
#pragma once
#include <random>

#include "framework/simulation/system.h"

namespace stroma::test {

/// Numbers between -size and size.
inline Vector randomRows(Index count, unsigned seed, double size = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-size, size);
  Vector rows(count);
  for (Index i = 0; i < count; ++i) rows[i] = Vec3(uniform(random), uniform(random), uniform(random));
  return rows;
}
/// Of all rows of a system; a row of one value has that alone.
inline Vector randomRows(const System& system, unsigned seed) {
  Vector rows = randomRows(system.allRows(), seed);
  for (Index i = 0; i < rows.count(); ++i)
    if (system.motion().kindOf(i) == RowKind::value) rows[i][1] = rows[i][2] = 0;
  return rows;
}

inline double farthest(const Vector& a, const Vector& b) {
  double largest = 0;
  for (Index i = 0; i < a.count(); ++i) largest = std::max(largest, (a[i] - b[i]).norm());
  return largest;
}

}  // namespace stroma::test
