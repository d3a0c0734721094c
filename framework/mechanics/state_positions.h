// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <limits>
#include <vector>

#include "framework/mechanics/state.h"

namespace stroma {

/// The rows of a state in its system's vector x [m], shape (state.size()).
inline std::vector<Vec3> positionsOf(const State& state, ConstRows x) {
  const ConstRows rows = state.segment(x);
  std::vector<Vec3> out(std::size_t(state.size()));
  for (Index i = 0; i < rows.count; ++i) out[std::size_t(i)] = rows[i];
  return out;
}

/// The position of every node, at rest or at the start [m], shape (state.nodes()).
inline std::vector<Vec3> nodePlaces(const State& state, const std::vector<Vec3>& rows) {
  if (state.rows_per_node == 1) return rows;
  std::vector<Vec3> places;
  for (Index node = 0; node < state.nodes(); ++node) places.push_back(rows[std::size_t(node * state.rows_per_node)]);
  return places;
}

/// The diagonal of the bounding box of a state's places [m], with position(i) of row i; zero without places.
template <class Position>
double sizeOfBox(const State& state, Position&& position) {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (Index i = 0; i < state.size(); ++i) {
    if (state.kindOf(i) != RowKind::place) continue;
    const Vec3 p = position(i);
    low = low.cwiseMin(p), high = high.cwiseMax(p);
  }
  return low[0] <= high[0] ? (high - low).norm() : 0;
}

/// The same for the rest shape [m].
inline double restSize(const State& state) {
  return sizeOfBox(state, [&state](Index i) -> const Vec3& { return state.rest_position[std::size_t(i)]; });
}

}  // namespace stroma
