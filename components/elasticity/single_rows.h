// SPDX-License-Identifier: LGPL-2.1-or-later
// Packs of single precision, two batches of a loop side by side, and rows of them: four floats (x, y, z, 0), so that the offsets of
// the rows of a Vector are theirs too. With registers of eight doubles; with shorter ones products gain nothing by it.
#pragma once
#include <array>
#include <limits>

#include "framework/algebra/parallel.h"
#include "framework/fem/pack.h"

#if defined(__AVX512F__)
#define STROMA_HAS_SINGLE_PACKS 1

namespace stroma::single {

constexpr int lanes = int(SinglePack::size);
static_assert(lanes == 2 * pack_lanes);

/// For as long as it lives numbers that are too small are zero: else each of them takes a hundred cycles.
struct FlushToZero {
  unsigned before = _mm_getcsr();
  FlushToZero() { _mm_setcsr(before | 0x8040u); }
  ~FlushToZero() { _mm_setcsr(before); }
  FlushToZero(const FlushToZero&) = delete;
};

/// The offsets of the eight lower and of the eight upper lanes.
struct Offsets {
  const Index *lower, *upper;
};

/// Four rows in each of four registers, then 4x4 transposes in their quarters.
inline V3<SinglePack> gatherRows(const float* data, const Offsets& at) {
  const auto quad = [&](int l) {  // rows of the lanes l, l + 4, l + 8, l + 12
    __m512 rows = _mm512_castps128_ps512(_mm_load_ps(data + at.lower[l]));
    rows = _mm512_insertf32x4(rows, _mm_load_ps(data + at.lower[l + 4]), 1);
    rows = _mm512_insertf32x4(rows, _mm_load_ps(data + at.upper[l]), 2);
    return _mm512_insertf32x4(rows, _mm_load_ps(data + at.upper[l + 4]), 3);
  };
  const __m512 r0 = quad(0), r1 = quad(1), r2 = quad(2), r3 = quad(3);
  const __m512d xy01 = _mm512_castps_pd(_mm512_unpacklo_ps(r0, r1)), xy23 = _mm512_castps_pd(_mm512_unpacklo_ps(r2, r3));
  const __m512d z01 = _mm512_castps_pd(_mm512_unpackhi_ps(r0, r1)), z23 = _mm512_castps_pd(_mm512_unpackhi_ps(r2, r3));
  return {SinglePack(_mm512_castpd_ps(_mm512_unpacklo_pd(xy01, xy23))),
          SinglePack(_mm512_castpd_ps(_mm512_unpackhi_pd(xy01, xy23))),
          SinglePack(_mm512_castpd_ps(_mm512_unpacklo_pd(z01, z23)))};
}

/// The lower (half 0) or upper lanes in double precision.
template <int half>
inline V3<Pack> widened(const V3<SinglePack>& v) {
  const auto wide = [](__m512 a) {
    const __m512d pairs = _mm512_castps_pd(a);
    return Pack(_mm512_cvtps_pd(_mm256_castpd_ps(half == 0 ? _mm512_castpd512_pd256(pairs) : _mm512_extractf64x4_pd(pairs, 1))));
  };
  return {wide(v.x), wide(v.y), wide(v.z)};
}

/// Writes the packs of a struct into the lower (half 0) or upper lanes of as many single ones.
template <class Packs>
void convert(const Packs& packs, int half, float* to) {
  const auto* from = reinterpret_cast<const double*>(&packs);
  for (std::size_t i = 0; i < sizeof(Packs) / sizeof(Pack); ++i)
    _mm256_store_ps(to + i * lanes + std::size_t(half) * pack_lanes, _mm512_cvtpd_ps(_mm512_load_pd(from + i * pack_lanes)));
}

/// Some rows of a vector in single precision. Loops take two rows at a time; where the last one is alone, the place beside it
/// is never read.
class Rows {
 public:
  void resize(Index first, Index last) {
    first_ = first, doubles_ = std::size_t(last - first) * row_doubles;
    numbers_.assign((doubles_ + pack_lanes - 1) / pack_lanes * pack_lanes, 0.f);
  }
  /// These rows of `a`, less their middle, which elements do not feel, times a power of two that makes the largest about 1.
  void take(ConstRows a) {
    const double* from = a.data + offset();
    __m512d middle;
    const double most = rangeOf(from, middle);
    scale_ = most > 0 && std::isfinite(most) ? std::exp2(-std::ilogb(most)) : 1;
    const __m512d scale = _mm512_set1_pd(scale_);
    forPieces([&](std::size_t begin, std::size_t end) {
      const FlushToZero flush;
      for (std::size_t i = begin; i < end; i += pack_lanes)
        _mm256_store_ps(numbers_.data() + i, _mm512_cvtpd_ps(_mm512_mul_pd(_mm512_sub_pd(pair(from, i), middle), scale)));
    });
  }
  /// Where row 0 would be.
  const float* data() const { return numbers_.data() - offset(); }
  double scale() const { return scale_; }

 private:
  std::size_t offset() const { return std::size_t(first_) * row_doubles; }
  __mmask8 mask(std::size_t i) const { return i + pack_lanes <= doubles_ ? __mmask8(0xff) : __mmask8(0x0f); }
  /// Two rows, or the last one and zeros.
  __m512d pair(const double* rows, std::size_t i) const { return _mm512_maskz_loadu_pd(mask(i), rows + i); }
  /// body(begin, end) of the numbers, on the threads.
  template <class Body>
  void forPieces(Body&& body) const {
    constexpr std::size_t piece = 65536;
    const std::size_t count = numbers_.size();
    parallelFor(int((count + piece - 1) / piece),
                [&](int k) { body(std::size_t(k) * piece, std::min(count, std::size_t(k + 1) * piece)); });
  }
  /// The middle of each component, twice; returns the largest distance from it.
  double rangeOf(const double* from, __m512d& middle) const {
    constexpr std::size_t chains = 4, step = chains * pack_lanes;  // comparisons of one chain wait for each other
    const __m512d first = _mm512_broadcast_f64x4(_mm256_loadu_pd(from));
    __m512d low[chains] = {first, first, first, first}, high[chains] = {first, first, first, first};
    const auto look = [&](std::size_t i, std::size_t k) {
      const __m512d rows = _mm512_mask_loadu_pd(first, mask(i), from + i);
      low[k] = _mm512_min_pd(low[k], rows), high[k] = _mm512_max_pd(high[k], rows);
    };
    std::size_t i = 0;
    for (; i + step <= doubles_; i += step)
      for (std::size_t k = 0; k < chains; ++k) {
        const __m512d rows = _mm512_loadu_pd(from + i + k * pack_lanes);
        low[k] = _mm512_min_pd(low[k], rows), high[k] = _mm512_max_pd(high[k], rows);
      }
    for (; i < doubles_; i += pack_lanes) look(i, 0);
    for (std::size_t k = 1; k < chains; ++k) low[0] = _mm512_min_pd(low[0], low[k]), high[0] = _mm512_max_pd(high[0], high[k]);
    const auto turned = [](__m512d v) { return _mm512_shuffle_f64x2(v, v, 0x4e); };  // the rows change places
    const __m512d least = _mm512_min_pd(low[0], turned(low[0])), greatest = _mm512_max_pd(high[0], turned(high[0]));
    middle = _mm512_mul_pd(_mm512_set1_pd(0.5), _mm512_add_pd(least, greatest));
    return _mm512_reduce_max_pd(_mm512_sub_pd(greatest, middle));
  }

  Array<float> numbers_;
  Index first_ = 0;
  std::size_t doubles_ = 0;
  double scale_ = 1;
};

}  // namespace stroma::single
#endif
