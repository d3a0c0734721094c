// SPDX-License-Identifier: LGPL-2.1-or-later
// A batch of pairs of frames: one number of each pair in an array, which is loaded as a pack.
#pragma once
#include <algorithm>
#include <array>
#include <vector>

#include "components/beams/relative_motion.h"

namespace stroma {

/// A number of each pair of a batch.
using Lanes = std::array<double, std::size_t(pack_lanes)>;
template <std::size_t N>
struct alignas(64) LanesOf : std::array<Lanes, N> {};

constexpr std::size_t batchesOf(std::size_t pairs) { return (pairs + std::size_t(pack_lanes) - 1) / std::size_t(pack_lanes); }
/// N numbers of each pair, value(pair, k), batch by batch; the last batch repeats its last pair in lanes that are left over.
template <std::size_t N, class Value>
std::vector<LanesOf<N>> lanesOf(std::size_t pairs, Value&& value) {
  std::vector<LanesOf<N>> batches(batchesOf(pairs));
  for (std::size_t i = 0; i < batches.size(); ++i)
    for (std::size_t k = 0; k < N; ++k)
      for (std::size_t lane = 0; lane < std::size_t(pack_lanes); ++lane)
        batches[i][k][lane] = value(std::min(i * std::size_t(pack_lanes) + lane, pairs - 1), k);
  return batches;
}

inline Pack packOf(const Lanes& lanes) { return Pack::load_aligned(lanes.data()); }
inline Triple<Pack> tripleOf(const V3<Pack>& v) { return {v.x, v.y, v.z}; }
inline Triple<PackJet> variables(const V3<Pack>& values, int first) {
  return {{values.x, first}, {values.y, first + 1}, {values.z, first + 2}};
}
template <std::size_t N>
V3<Pack> vectorIn(const LanesOf<N>& lanes, std::size_t first = 0) {
  return {packOf(lanes[first]), packOf(lanes[first + 1]), packOf(lanes[first + 2])};
}
template <class Vector, std::size_t N>
void put(const Vector& v, LanesOf<N>& lanes, std::size_t first = 0) {
  v.x.store_aligned(lanes[first].data()), v.y.store_aligned(lanes[first + 1].data()), v.z.store_aligned(lanes[first + 2].data());
}
inline void put(const M3<Pack>& m, LanesOf<9>& lanes) { put(m.c0, lanes, 0), put(m.c1, lanes, 3), put(m.c2, lanes, 6); }

/// The orientations in a pack of rows.
#if defined(__AVX512F__)
inline Orientation<Pack> orientationsAt(const double* data, const Index* offset) {  // gatherRows() with the fourth numbers
  const auto row = [&](int l) { return _mm256_load_pd(data + offset[l]); };
  const auto pair = [&](int l) { return _mm512_insertf64x4(_mm512_castpd256_pd512(row(l)), row(l + 4), 1); };
  const __m512d r0 = pair(0), r1 = pair(1), r2 = pair(2), r3 = pair(3);  // x y z w of lanes l and l + 4
  const __m512d xz01 = _mm512_unpacklo_pd(r0, r1), xz23 = _mm512_unpacklo_pd(r2, r3);
  const __m512d yw01 = _mm512_unpackhi_pd(r0, r1), yw23 = _mm512_unpackhi_pd(r2, r3);
  const __m512i first = _mm512_setr_epi64(0, 1, 8, 9, 4, 5, 12, 13), second = _mm512_setr_epi64(2, 3, 10, 11, 6, 7, 14, 15);
  return {{Pack(_mm512_permutex2var_pd(xz01, first, xz23)), Pack(_mm512_permutex2var_pd(yw01, first, yw23)),
           Pack(_mm512_permutex2var_pd(xz01, second, xz23))},
          Pack(_mm512_permutex2var_pd(yw01, second, yw23))};
}
#else
inline Orientation<Pack> orientationsAt(const double* data, const Index* offset) {
  alignas(64) Lanes w;
  for (std::size_t lane = 0; lane < w.size(); ++lane) w[lane] = data[offset[lane] + 3];
  return {gatherRows(data, offset), packOf(w)};
}
#endif

}  // namespace stroma
