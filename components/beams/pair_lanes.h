// SPDX-License-Identifier: LGPL-2.1-or-later
// A batch of pairs of frames: a number of each in an array, which is loaded as a pack.
#pragma once
#include <array>

#include "components/beams/relative_motion.h"

namespace stroma {

/// A number of each pair of a batch.
using Lanes = std::array<double, std::size_t(pack_lanes)>;
template <std::size_t N>
struct alignas(64) LanesOf : std::array<Lanes, N> {
  Triple<double> of(std::size_t lane) const requires(N == 3) { return {(*this)[0][lane], (*this)[1][lane], (*this)[2][lane]}; }
};

inline Pack packOf(const Lanes& lanes) { return Pack::load_aligned(lanes.data()); }
template <std::size_t N>
V3<Pack> vectorIn(const LanesOf<N>& lanes, std::size_t first = 0) {
  return {packOf(lanes[first]), packOf(lanes[first + 1]), packOf(lanes[first + 2])};
}
/// Columns.
inline M3<Pack> matrixIn(const LanesOf<9>& lanes) { return {vectorIn(lanes, 0), vectorIn(lanes, 3), vectorIn(lanes, 6)}; }
template <class Vector, std::size_t N>
void put(const Vector& v, LanesOf<N>& lanes, std::size_t first = 0) {
  v.x.store_aligned(lanes[first].data()), v.y.store_aligned(lanes[first + 1].data()), v.z.store_aligned(lanes[first + 2].data());
}
inline void put(const M3<Pack>& m, LanesOf<9>& lanes) { put(m.c0, lanes, 0), put(m.c1, lanes, 3), put(m.c2, lanes, 6); }

}  // namespace stroma
