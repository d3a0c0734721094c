// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "framework/mechanics/state.h"

namespace stroma {

/// The rows of a state in its system's vector x [m], shape (state.size()).
inline std::vector<Vec3> positionsOf(const State& state, ConstRows x) {
  std::vector<Vec3> out(std::size_t(state.size()));
  for (Index i = 0; i < state.size(); ++i) out[i] = x[state.firstRow() + i];
  return out;
}

/// The diagonal of the box around a state's rest shape [m].
inline double restSize(const State& state) {
  if (state.rest_position.empty()) return 0;
  Vec3 low = state.rest_position[0], high = low;
  for (const Vec3& p : state.rest_position) low = low.cwiseMin(p), high = high.cwiseMax(p);
  return (high - low).norm();
}

}  // namespace stroma
