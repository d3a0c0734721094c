// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "framework/mechanics/state.h"

namespace stroma {

/// The rows of a state in its system's vector x [m], shape (state.size()).
inline std::vector<Vec3> positionsOf(const State& state, ConstRows x) {
  std::vector<Vec3> out(std::size_t(state.size()));
  for (Index i = 0; i < state.size(); ++i) out[std::size_t(i)] = x[state.firstRow() + i];
  return out;
}

}  // namespace stroma
