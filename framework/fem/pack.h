// SPDX-License-Identifier: LGPL-2.1-or-later
// Packs: as many doubles as the registers of the instruction set hold; lane l of every pack belongs to element l of a
// batch. Small vectors and matrices of packs, and the transposes between rows of a Vector and packs. Everything is a
// template on the number type, so that the same mathematics runs on a double in a test.
#pragma once
#include <immintrin.h>

#include <cmath>
#include <xsimd/xsimd.hpp>

#include "framework/algebra/vector.h"

namespace stroma {

using Pack = xsimd::batch<double>;
/// Elements in a batch: 8 with AVX-512, 4 with AVX, 2 with SSE.
constexpr int pack_lanes = int(Pack::size);

// ---- the operations that kernels use, also for a plain double ----

inline double fma(double a, double b, double c) { return a * b + c; }
/// a where the condition holds, else b, lane by lane; both are computed.
inline double select(bool condition, double a, double b) { return condition ? a : b; }
/// True when the condition holds in a lane: for branches that skip rare work.
inline bool any(bool condition) { return condition; }
using std::abs;
using std::sqrt;
inline double maximum(double a, double b) { return a > b ? a : b; }

inline Pack fma(Pack a, Pack b, Pack c) { return xsimd::fma(a, b, c); }
inline Pack select(Pack::batch_bool_type condition, Pack a, Pack b) { return xsimd::select(condition, a, b); }
inline bool any(Pack::batch_bool_type condition) { return xsimd::any(condition); }
inline Pack abs(Pack a) { return xsimd::abs(a); }
inline Pack sqrt(Pack a) { return xsimd::sqrt(a); }
inline Pack maximum(Pack a, Pack b) { return xsimd::max(a, b); }

/// 1/sqrt(a) for a > 0, to 2 units in the last place.
inline double reciprocalSqrt(double a) { return 1 / std::sqrt(a); }
/// a^(1/4) for a > 0, to four digits: for scalings that need no more.
inline double roughFourthRoot(double a) { return std::sqrt(std::sqrt(a)); }
#if defined(__AVX512F__)
/// The 14 bits of the instruction and two Newton steps: a quarter of the time of a square root and a division.
inline Pack reciprocalSqrt(Pack a) {
  Pack y = _mm512_rsqrt14_pd(a);
  const Pack half_a = a * Pack(0.5);
  for (int step = 0; step < 2; ++step) y = y * xsimd::fnma(half_a * y, y, Pack(1.5));
  return y;
}
inline Pack roughFourthRoot(Pack a) { return Pack(_mm512_rsqrt14_pd(_mm512_rsqrt14_pd(a))); }
#else
inline Pack reciprocalSqrt(Pack a) { return Pack(1.) / sqrt(a); }
inline Pack roughFourthRoot(Pack a) { return sqrt(sqrt(a)); }
#endif

// ---- 3-vectors and 3x3 matrices (columns) ----

/// A 3-vector of numbers or packs; zero unless given.
template <class T>
struct V3 {
  T x = T(0.), y = T(0.), z = T(0.);
  V3 operator+(const V3& b) const { return {x + b.x, y + b.y, z + b.z}; }
  V3 operator-(const V3& b) const { return {x - b.x, y - b.y, z - b.z}; }
  V3 operator*(T s) const { return {x * s, y * s, z * s}; }
  V3 operator-() const { return {-x, -y, -z}; }
};
template <class T>
T dot(const V3<T>& a, const V3<T>& b) {
  return fma(a.x, b.x, fma(a.y, b.y, a.z * b.z));
}
template <class T>
V3<T> cross(const V3<T>& a, const V3<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
/// a + s b
template <class T>
V3<T> fma(T s, const V3<T>& b, const V3<T>& a) {
  return {fma(s, b.x, a.x), fma(s, b.y, a.y), fma(s, b.z, a.z)};
}
template <class Condition, class T>
V3<T> select(Condition condition, const V3<T>& a, const V3<T>& b) {
  return {select(condition, a.x, b.x), select(condition, a.y, b.y), select(condition, a.z, b.z)};
}

/// Columns c0, c1, c2.
template <class T>
struct M3 {
  V3<T> c0, c1, c2;
  M3 operator+(const M3& b) const { return {c0 + b.c0, c1 + b.c1, c2 + b.c2}; }
  M3 operator-(const M3& b) const { return {c0 - b.c0, c1 - b.c1, c2 - b.c2}; }
  M3 operator*(T s) const { return {c0 * s, c1 * s, c2 * s}; }
  /// this * v
  V3<T> operator*(const V3<T>& v) const { return fma(v.x, c0, fma(v.y, c1, c2 * v.z)); }
  M3 operator*(const M3& b) const { return {*this * b.c0, *this * b.c1, *this * b.c2}; }
};
/// a^T v
template <class T>
V3<T> transposedTimes(const M3<T>& a, const V3<T>& v) {
  return {dot(a.c0, v), dot(a.c1, v), dot(a.c2, v)};
}
/// a^T b
template <class T>
M3<T> transposedTimes(const M3<T>& a, const M3<T>& b) {
  return {transposedTimes(a, b.c0), transposedTimes(a, b.c1), transposedTimes(a, b.c2)};
}
template <class T>
M3<T> transpose(const M3<T>& a) {
  return {{a.c0.x, a.c1.x, a.c2.x}, {a.c0.y, a.c1.y, a.c2.y}, {a.c0.z, a.c1.z, a.c2.z}};
}
/// Cofactor matrix: cof(A) = det(A) A^-T; its columns are cross products of columns of A.
template <class T>
M3<T> cofactor(const M3<T>& a) {
  return {cross(a.c1, a.c2), cross(a.c2, a.c0), cross(a.c0, a.c1)};
}
/// Sum of the squares of all nine entries.
template <class T>
T squaredNorm(const M3<T>& a) {
  return dot(a.c0, a.c0) + dot(a.c1, a.c1) + dot(a.c2, a.c2);
}
template <class T>
M3<T> identity() {
  return {{T(1.), T(0.), T(0.)}, {T(0.), T(1.), T(0.)}, {T(0.), T(0.), T(1.)}};
}
template <class Condition, class T>
M3<T> select(Condition condition, const M3<T>& a, const M3<T>& b) {
  return {select(condition, a.c0, b.c0), select(condition, a.c1, b.c1), select(condition, a.c2, b.c2)};
}
/// Symmetric 3x3 matrix.
template <class T>
struct S3 {
  T xx = T(0.), yy = T(0.), zz = T(0.), xy = T(0.), yz = T(0.), zx = T(0.);
  S3 operator+(const S3& b) const { return {xx + b.xx, yy + b.yy, zz + b.zz, xy + b.xy, yz + b.yz, zx + b.zx}; }
  S3 operator*(T s) const { return {xx * s, yy * s, zz * s, xy * s, yz * s, zx * s}; }
  V3<T> operator*(const V3<T>& v) const {
    return {fma(xx, v.x, fma(xy, v.y, zx * v.z)), fma(xy, v.x, fma(yy, v.y, yz * v.z)), fma(zx, v.x, fma(yz, v.y, zz * v.z))};
  }
};

// ---- rows of a Vector to packs and back; offset[l] is the row of lane l times row_doubles: an address needs no shift ----

#if defined(__AVX512F__)

/// Rows offset[0..7] as packs x, y, z: eight 32-byte loads. A register holds lanes l and l + 2, so that what is left at the end is to
/// move whole 16-byte parts: that needs no table of indices, and no copy of what a table's instruction overwrites.
inline V3<Pack> gatherRows(const double* data, const Index* offset) {
  const auto row = [&](int l) { return _mm256_load_pd(data + offset[l]); };
  const auto pair = [&](int l) { return _mm512_insertf64x4(_mm512_castpd256_pd512(row(l)), row(l + 2), 1); };
  const __m512d r02 = pair(0), r13 = pair(1), r46 = pair(4), r57 = pair(5);                     // x y z 0 of two lanes
  const __m512d xz_low = _mm512_unpacklo_pd(r02, r13), xz_high = _mm512_unpacklo_pd(r46, r57);  // x0 x1 z0 z1 x2 x3 z2 z3 | ...
  const __m512d y_low = _mm512_unpackhi_pd(r02, r13), y_high = _mm512_unpackhi_pd(r46, r57);    // y0 y1 0 0 y2 y3 0 0 | ...
  return {Pack(_mm512_shuffle_f64x2(xz_low, xz_high, 0x88)), Pack(_mm512_shuffle_f64x2(y_low, y_high, 0x88)),
          Pack(_mm512_shuffle_f64x2(xz_low, xz_high, 0xdd))};
}

/// use(lane, row) for each lane in order, row an __m256d: x y z w.
template <class Use>
inline void forEachRow(const V3<Pack>& v, Use&& use, const Pack& fourth = Pack(0.)) {
  const __m512d x = v.x, y = v.y, z = v.z, w = fourth;
  const __m512d xy_even = _mm512_unpacklo_pd(x, y), xy_odd = _mm512_unpackhi_pd(x, y);  // x0 y0 x2 y2 | ...
  const __m512d z_even = _mm512_unpacklo_pd(z, w), z_odd = _mm512_unpackhi_pd(z, w);    // z0 w0 z2 w2 | ...
  const __m512i low = _mm512_setr_epi64(0, 1, 8, 9, 4, 5, 12, 13);
  const __m512i high = _mm512_setr_epi64(2, 3, 10, 11, 6, 7, 14, 15);
  const __m512d r04 = _mm512_permutex2var_pd(xy_even, low, z_even), r15 = _mm512_permutex2var_pd(xy_odd, low, z_odd);
  const __m512d r26 = _mm512_permutex2var_pd(xy_even, high, z_even), r37 = _mm512_permutex2var_pd(xy_odd, high, z_odd);
  use(0, _mm512_castpd512_pd256(r04));
  use(1, _mm512_castpd512_pd256(r15));
  use(2, _mm512_castpd512_pd256(r26));
  use(3, _mm512_castpd512_pd256(r37));
  use(4, _mm512_extractf64x4_pd(r04, 1));
  use(5, _mm512_extractf64x4_pd(r15, 1));
  use(6, _mm512_extractf64x4_pd(r26, 1));
  use(7, _mm512_extractf64x4_pd(r37, 1));
}

#elif defined(__AVX__)

inline V3<Pack> gatherRows(const double* data, const Index* offset) {
  const auto row = [&](int l) { return _mm256_load_pd(data + offset[l]); };
  const __m256d r0 = row(0), r1 = row(1), r2 = row(2), r3 = row(3);
  const __m256d xz01 = _mm256_unpacklo_pd(r0, r1), xz23 = _mm256_unpacklo_pd(r2, r3);
  const __m256d y01 = _mm256_unpackhi_pd(r0, r1), y23 = _mm256_unpackhi_pd(r2, r3);
  return {Pack(_mm256_permute2f128_pd(xz01, xz23, 0x20)), Pack(_mm256_permute2f128_pd(y01, y23, 0x20)),
          Pack(_mm256_permute2f128_pd(xz01, xz23, 0x31))};
}
template <class Use>
inline void forEachRow(const V3<Pack>& v, Use&& use, const Pack& fourth = Pack(0.)) {
  const __m256d x = v.x, y = v.y, z = v.z, w = fourth;
  const __m256d xy02 = _mm256_unpacklo_pd(x, y), xy13 = _mm256_unpackhi_pd(x, y);
  const __m256d z02 = _mm256_unpacklo_pd(z, w), z13 = _mm256_unpackhi_pd(z, w);
  use(0, _mm256_permute2f128_pd(xy02, z02, 0x20));
  use(1, _mm256_permute2f128_pd(xy13, z13, 0x20));
  use(2, _mm256_permute2f128_pd(xy02, z02, 0x31));
  use(3, _mm256_permute2f128_pd(xy13, z13, 0x31));
}

#else

inline V3<Pack> gatherRows(const double* data, const Index* offset) {
  alignas(64) double x[pack_lanes], y[pack_lanes], z[pack_lanes];
  for (int l = 0; l < pack_lanes; ++l) {
    const double* row = data + offset[l];
    x[l] = row[0], y[l] = row[1], z[l] = row[2];
  }
  return {Pack::load_aligned(x), Pack::load_aligned(y), Pack::load_aligned(z)};
}
template <class Use>
inline void forEachRow(const V3<Pack>& v, Use&& use, const Pack& fourth = Pack(0.)) {
  alignas(64) double x[pack_lanes], y[pack_lanes], z[pack_lanes], w[pack_lanes];
  v.x.store_aligned(x), v.y.store_aligned(y), v.z.store_aligned(z), fourth.store_aligned(w);
  for (int l = 0; l < pack_lanes; ++l) use(l, std::array<double, 4>{x[l], y[l], z[l], w[l]});
}

#endif

#if defined(__AVX__)
inline void addRow(__m256d value, double* row) { _mm256_storeu_pd(row, _mm256_add_pd(_mm256_loadu_pd(row), value)); }
inline void setRow(__m256d value, double* row) { _mm256_store_pd(row, value); }
#else
inline void addRow(const std::array<double, 4>& value, double* row) {
  for (std::size_t c = 0; c < 4; ++c) row[c] += value[c];
}
inline void setRow(const std::array<double, 4>& value, double* row) { std::copy(value.begin(), value.end(), row); }
#endif

/// rows offset[l] += v, lane by lane, in the order of the lanes: lanes may share a row.
inline void addToRows(const V3<Pack>& v, const Index* offset, double* data) {
  forEachRow(v, [&](int l, const auto& row) { addRow(row, data + offset[l]); });
}
/// blocks slot[l] of nine doubles += s k, for the first `lanes` lanes.
inline void addToBlocks(const Pack* k, Pack s, const Index* slot, int lanes, double* data) {
  alignas(64) double last[pack_lanes];
  (k[8] * s).store_aligned(last);
  for (int part = 0; part < 8; part += 4)
    forEachRow(
        V3<Pack>{k[part] * s, k[part + 1] * s, k[part + 2] * s},
        [&](int l, const auto& four) {
          if (l >= lanes) return;
          double* block = data + std::size_t(slot[l]) * 9;
          addRow(four, block + part);
          if (part == 4) block[8] += last[l];
        },
        k[part + 3] * s);
}
/// rows 0 to pack_lanes - 1 of data = v.
inline void setRows(const V3<Pack>& v, double* data) {
  forEachRow(v, [&](int l, const auto& row) { setRow(row, data + l * row_doubles); });
}

}  // namespace stroma
