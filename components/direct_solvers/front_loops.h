// SPDX-License-Identifier: LGPL-2.1-or-later
// The bodies of FrontKernels for the instruction set that the including source is compiled for.
#pragma once
#if defined(__AVX512F__)
#include <immintrin.h>
#endif

#include "components/direct_solvers/front_kernels.h"

namespace stroma {
namespace {

#if defined(__AVX512F__)
constexpr int register_bytes = 64, tile_columns = 8;
#elif defined(__AVX__)
constexpr int register_bytes = 32, tile_columns = 4;
#else
constexpr int register_bytes = 16, tile_columns = 4;
#endif
constexpr int tile_registers = 3;

struct Loops {
  static constexpr int lanes = register_bytes / int(sizeof(float));
  using Wide [[gnu::vector_size(register_bytes), gnu::aligned(sizeof(float)), gnu::may_alias]] = float;
  static constexpr int N = tile_columns;

  static Wide load(const float* from) { return *reinterpret_cast<const Wide*>(from); }
  static void store(float* to, Wide value) { *reinterpret_cast<Wide*>(to) = value; }

  /// sum += A B^T of V registers of rows and N columns.
  template <int V>
  [[gnu::always_inline]] static void product(const float* a, int lda, const float* b, int ldb, int depth, Wide (&sum)[N][V]) {
    for (int k = 0; k < depth; ++k, a += lda, b += ldb) {
      Wide left[V];
#pragma GCC unroll 8
      for (int v = 0; v < V; ++v) left[v] = load(a + v * lanes);
#pragma GCC unroll 8
      for (int n = 0; n < N; ++n) {
        const Wide right = b[n] - Wide{};
#pragma GCC unroll 8
        for (int v = 0; v < V; ++v) sum[n][v] += left[v] * right;
      }
    }
  }
  template <int V>
  static void subtractTile(const float* a, int lda, const float* b, int ldb, int count, int depth, bool is_fresh, float* c,
                           int ldc) {
    Wide sum[N][V] = {};
    product<V>(a, lda, b, ldb, depth, sum);
#pragma GCC unroll 8
    for (int n = 0; n < N; ++n) {
      if (n >= count) continue;
#pragma GCC unroll 8
      for (int v = 0; v < V; ++v) {
        float* const to = c + long(n) * ldc + v * lanes;
        store(to, (is_fresh ? Wide{} : load(to)) - sum[n][v]);
      }
    }
  }
  /// Columns j to j + count of B <- B L^-T, whose columns before are done. `l`: row j of L; `corner`: L at (j, j).
  template <int V>
  static void solveTile(const float* l, int ldl, const float* corner, int ld_corner, int j, int count, float* b, int ldb) {
    Wide sum[N][V] = {};
    product<V>(b, ldb, l, ldl, j, sum);
    float* const own = b + long(j) * ldb;
#pragma GCC unroll 8
    for (int n = 0; n < N; ++n) {
      if (n >= count) continue;
#pragma GCC unroll 8
      for (int v = 0; v < V; ++v) sum[n][v] = load(own + long(n) * ldb + v * lanes) - sum[n][v];
#pragma GCC unroll 8
      for (int d = 0; d < n; ++d) {
        const Wide factor = corner[n + d * ld_corner] - Wide{};
#pragma GCC unroll 8
        for (int v = 0; v < V; ++v) sum[n][v] -= sum[d][v] * factor;
      }
      const Wide inverse = corner[n + n * ld_corner] - Wide{};
#pragma GCC unroll 8
      for (int v = 0; v < V; ++v) {
        sum[n][v] *= inverse;
        store(own + long(n) * ldb + v * lanes, sum[n][v]);
      }
    }
  }
  /// body(i, V) for rows in registers, tile_registers at a time.
  template <class Body>
  [[gnu::always_inline]] static void forTiles(int first, int rows, Body&& body) {
    int i = first;
    for (; i + 3 * lanes <= rows; i += 3 * lanes) body.template operator()<3>(i);
    if (i + 2 * lanes <= rows) body.template operator()<2>(i), i += 2 * lanes;
    if (i + lanes <= rows) body.template operator()<1>(i);
  }
  static int padded(int n) { return (n + front_rows - 1) / front_rows * front_rows; }

  static int factor(float* a, int lda, int n) {
    static_assert(front_rows % lanes == 0 && front_columns % front_rows == 0);
    for (int j = 0; j < n; j += N) {
      const int count = n - j < N ? n - j : N;
      constexpr int V = N > lanes ? N / lanes : 1;
      Wide sum[N][V] = {};
      product<V>(a + j, lda, a + j, lda, j, sum);
      float corner[N * N];
      for (int c = 0; c < count; ++c)
        for (int r = c; r < count; ++r) corner[r + c * N] = a[j + r + long(j + c) * lda] - sum[c][r / lanes][r % lanes];
      for (int c = 0; c < count; ++c) {
        float pivot = corner[c + c * N];
        if (!(pivot > 0)) return j + c;
        const float inverse = 1 / __builtin_sqrtf(pivot);
        corner[c + c * N] = inverse;
        for (int r = c + 1; r < count; ++r) corner[r + c * N] *= inverse;
        for (int d = c + 1; d < count; ++d)
          for (int r = d; r < count; ++r) corner[r + d * N] -= corner[r + c * N] * corner[d + c * N];
      }
      const int from = j / front_rows * front_rows, last = padded(n);
      if (j + N < n)
        forTiles(from, last, [&]<int V>(int i) { solveTile<V>(a + j, lda, corner, N, j, count, a + i, lda); });
      for (int c = 0; c < count; ++c)
        for (int r = c; r < count; ++r) a[j + r + long(j + c) * lda] = corner[r + c * N];
    }
    return -1;
  }

  static void solveRows(const float* l, int ldl, int n, float* b, int ldb, int rows) {
    forTiles(0, padded(rows), [&]<int V>(int i) {
      for (int j = 0; j < n; j += N)
        solveTile<V>(l + j, ldl, l + j + long(j) * ldl, ldl, j, n - j < N ? n - j : N, b + i, ldb);
    });
  }

  static void subtract(const float* a, int lda, int rows, const float* b, int ldb, int columns, int depth, bool is_fresh, float* c,
                       int ldc) {
    forTiles(0, padded(rows), [&]<int V>(int i) {
      for (int j = 0; j < columns; j += N)
        subtractTile<V>(a + i, lda, b + j, ldb, columns - j, depth, is_fresh, c + i + long(j) * ldc, ldc);
    });
  }

  static void subtractLower(const float* a, int lda, int n, int depth, bool is_fresh, float* c, int ldc) {
    constexpr int most = 3 * lanes;
    const int rows = padded(n);
    for (int i = 0; i < rows; i += most) {
      const int count = rows - i < most ? rows - i : most;
      const int whole = i < n ? i : n;
      int j = 0;
      if (count == most)
        for (; j < whole; j += N) subtractTile<3>(a + i, lda, a + j, lda, n - j, depth, is_fresh, c + i + long(j) * ldc, ldc);
      for (; j < i + count && j < n; j += N) {
        const int from = j <= i ? i : i + (j - i) / lanes * lanes;
        forTiles(from, i + count, [&]<int V>(int at) {
          subtractTile<V>(a + at, lda, a + j, lda, n - j, depth, is_fresh, c + at + long(j) * ldc, ldc);
        });
      }
    }
  }

  /// to += what
  [[gnu::always_inline]] static void addRun(float* to, const float* what, int count) {
#if defined(__AVX512F__)
    for (; count > 0; count -= lanes, to += lanes, what += lanes) {
      const __mmask16 mask = count >= lanes ? 0xffff : __mmask16((1u << count) - 1);
      _mm512_mask_storeu_ps(to, mask, _mm512_add_ps(_mm512_maskz_loadu_ps(mask, to), _mm512_maskz_loadu_ps(mask, what)));
    }
#else
    for (int i = 0; i < count; ++i) to[i] += what[i];
#endif
  }
  static int smaller(int a, int b) { return a < b ? a : b; }
  static void add(const FrontParts& child, const FrontRun* begin, const FrontRun* end, const FrontParts& parent,
                  int first, int last) {
    for (const FrontRun* columns = begin; columns != end; ++columns) {
      const int c_first = first > columns->to ? first - columns->to : 0, c_last = smaller(columns->count, last - columns->to);
      if (c_first >= c_last) continue;
      const float* const what = child.update + long(columns->from) * child.below_rows;
      const bool is_own = columns->to < parent.columns;
      // the parent's columns, as if the rows of each lay one behind the other
      const long upper_rows = parent.triangle_rows, lower_rows = parent.below_rows;
      float* const upper = parent.triangle + columns->to * upper_rows;
      float* const part = is_own ? parent.rest : parent.update - parent.columns * lower_rows;
      float* const lower = part + columns->to * lower_rows - parent.columns;
      const long own_rows = is_own ? upper_rows : lower_rows;
      for (int c = c_first; c < c_last; ++c)
        addRun((is_own ? upper : lower) + c * own_rows + columns->to + c, what + long(c) * child.below_rows + columns->from + c,
               columns->count - c);
      // block by block: numbers that were just written cannot be read again at once
      for (const FrontRun* rows = columns + 1; rows != end; ++rows) {
        const bool is_upper = rows->to < parent.columns;
        float* const to = (is_upper ? upper : lower) + rows->to;
        const long to_rows = is_upper ? upper_rows : lower_rows;
        for (int c = c_first; c < c_last; ++c)
          addRun(to + c * to_rows, what + long(c) * child.below_rows + rows->from, rows->count);
      }
    }
  }

  static void subtractProduct(const float* a, int lda, int rows, int columns, const float* x, float* y) {
    constexpr int wide = 8;
    const int all = padded(rows);
    int j = 0;
    for (; j + wide <= columns; j += wide) {
      Wide factor[wide];
#pragma GCC unroll 8
      for (int k = 0; k < wide; ++k) factor[k] = x[j + k] - Wide{};
      const float* column = a + long(j) * lda;
      for (int i = 0; i < all; i += lanes) {
        Wide even = load(y + i), odd{};
#pragma GCC unroll 8
        for (int k = 0; k < wide; k += 2) {
          even -= load(column + long(k) * lda + i) * factor[k];
          odd -= load(column + long(k + 1) * lda + i) * factor[k + 1];
        }
        store(y + i, even + odd);
      }
    }
    for (; j < columns; ++j)
      for (int i = 0; i < all; i += lanes) store(y + i, load(y + i) - load(a + long(j) * lda + i) * x[j]);
  }

  static float total(Wide value) {
    float sum = 0;
    for (int l = 0; l < lanes; ++l) sum += value[l];
    return sum;
  }
  static void subtractTransposed(const float* a, int lda, int rows, int columns, const float* x, float* y) {
    constexpr int wide = 4;
    const int all = padded(rows);
    int j = 0;
    for (; j + wide <= columns; j += wide) {
      Wide sum[wide] = {};
      const float* column = a + long(j) * lda;
      for (int i = 0; i < all; i += lanes) {
        const Wide value = load(x + i);
#pragma GCC unroll 8
        for (int k = 0; k < wide; ++k) sum[k] += load(column + long(k) * lda + i) * value;
      }
#pragma GCC unroll 8
      for (int k = 0; k < wide; ++k) y[j + k] -= total(sum[k]);
    }
    for (; j < columns; ++j) {
      Wide sum{};
      for (int i = 0; i < all; i += lanes) sum += load(a + long(j) * lda + i) * load(x + i);
      y[j] -= total(sum);
    }
  }

  // By blocks of columns; what is below a block goes by whole registers, so that x needs front_rows more numbers behind it.
  static void solveForward(const float* l, int ldl, int n, float* x) {
    for (int j = 0; j < n; j += front_rows) {
      const int last = n - j < front_rows ? n : j + front_rows;
      for (int c = j; c < last; ++c) {
        const float* column = l + long(c) * ldl;
        const float value = x[c] *= column[c];
        for (int r = c + 1; r < last; ++r) x[r] -= column[r] * value;
      }
      if (last < n) subtractProduct(l + last + long(j) * ldl, ldl, n - last, last - j, x + j, x + last);
    }
  }
  static void solveBackward(const float* l, int ldl, int n, float* x) {
    for (int j = (n - 1) / front_rows * front_rows; j >= 0; j -= front_rows) {
      const int last = n - j < front_rows ? n : j + front_rows;
      if (last < n) subtractTransposed(l + last + long(j) * ldl, ldl, n - last, last - j, x + last, x + j);
      for (int c = last - 1; c >= j; --c) {
        const float* column = l + long(c) * ldl;
        float sum = x[c];
        for (int r = c + 1; r < last; ++r) sum -= column[r] * x[r];
        x[c] = sum * column[c];
      }
    }
  }
};

constexpr FrontKernels loops = {Loops::factor,          Loops::solveRows,
                                      Loops::subtract,        Loops::subtractLower,   Loops::add,
                                      Loops::subtractProduct, Loops::subtractTransposed,
                                      Loops::solveForward,    Loops::solveBackward};

}  // namespace
}  // namespace stroma
