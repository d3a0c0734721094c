// SPDX-License-Identifier: LGPL-2.1-or-later
// Panels of supernodes with few columns, on which the BLAS spends more for each call than for the numbers: chains of frames and the
// leaves of elimination trees. Columns are `stride` apart.
#pragma once
#include <cmath>

namespace stroma {

/// Panels of at most this many multiply-adds are faster here.
constexpr double most_small_operations = 6000;

namespace small_panels {

/// out -= sum over `depth` columns of a of column k times factors[k stride], shape (rows).
[[gnu::always_inline]] inline void subtractColumns(const double* __restrict a, long stride, int depth, const double* factors,
                                                   int rows, double* __restrict out) {
  int k = 0;
  for (; k + 4 <= depth; k += 4, a += 4 * stride, factors += 4 * stride) {
    const double p = factors[0], q = factors[stride], r = factors[2 * stride], s = factors[3 * stride];
    const double *b = a + stride, *c = b + stride, *d = c + stride;
#pragma omp simd
    for (int i = 0; i < rows; ++i) out[i] -= (p * a[i] + q * b[i]) + (r * c[i] + s * d[i]);
  }
  for (; k < depth; ++k, a += stride, factors += stride) {
    const double p = factors[0];
#pragma omp simd
    for (int i = 0; i < rows; ++i) out[i] -= p * a[i];
  }
}

/// The first columns become L of A = L L^T, the rows below them L^-T from the right. Returns as LAPACK does which pivot, from 1 on,
/// is not positive.
[[gnu::always_inline]] inline int factorBody(double* panel, int columns, int height) {
  const long stride = height;
  for (int j = 0; j < columns; ++j) {
    double* const own = panel + j * stride + j;
    subtractColumns(panel + j, stride, j, panel + j, height - j, own);
    if (!(*own > 0)) return j + 1;
    const double root = std::sqrt(*own), inverse = 1 / root;
    *own = root;
#pragma omp simd
    for (int i = 1; i < height - j; ++i) own[i] *= inverse;
  }
  return 0;
}

/// Column j of an update, from its row j on: minus the sum over `depth` columns of a times their rows j.
[[gnu::always_inline]] inline void updateBody(const double* a, long stride, int depth, int wide, int height, double* update) {
  for (int j = 0; j < wide; ++j) {
    double* const own = update + long(j) * height + j;
    for (int i = 0; i < height - j; ++i) own[i] = 0;
    subtractColumns(a + j, stride, depth, a + j, height - j, own);
  }
}

inline int factorNarrow(double* panel, int columns, int height) { return factorBody(panel, columns, height); }
[[gnu::target("avx2,fma")]] inline int factorWide(double* panel, int columns, int height) {
  return factorBody(panel, columns, height);
}
inline void updateNarrow(const double* a, long stride, int depth, int wide, int height, double* update) {
  updateBody(a, stride, depth, wide, height, update);
}
[[gnu::target("avx2,fma")]] inline void updateWide(const double* a, long stride, int depth, int wide, int height, double* update) {
  updateBody(a, stride, depth, wide, height, update);
}
inline bool isWide() { return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"); }
inline int factor(double* panel, int columns, int height) {
  static const auto chosen = isWide() ? factorWide : factorNarrow;
  return chosen(panel, columns, height);
}
inline void update(const double* a, long stride, int depth, int wide, int height, double* update) {
  static const auto chosen = isWide() ? updateWide : updateNarrow;
  chosen(a, stride, depth, wide, height, update);
}

}  // namespace small_panels
}  // namespace stroma
