// SPDX-License-Identifier: LGPL-2.1-or-later
// The bodies of SideKernels for the instruction set that the including source is compiled for: a tile of rows of x, all sides, is kept in
// registers while a row of numbers of L is read.
#pragma once
#include "components/direct_solvers/side_kernels.h"

namespace stroma {
namespace {

#if defined(__AVX512F__)
constexpr int side_bytes = 64, side_tile = 8;
#elif defined(__AVX__)
constexpr int side_bytes = 32, side_tile = 2;
#else
constexpr int side_bytes = 16, side_tile = 1;
#endif

template <class Number>
struct SideLoops {
  using Panel = SidePanel<Number>;
  using Wide [[gnu::vector_size(side_bytes), gnu::aligned(sizeof(Number)), gnu::may_alias]] = Number;
  static constexpr int lanes = side_bytes / int(sizeof(Number)), V = sides<Number> / lanes;

  static Wide load(const Number* from) { return *reinterpret_cast<const Wide*>(from); }
  static void store(Number* to, Wide value) { *reinterpret_cast<Wide*>(to) = value; }
  static Number* at(Number* x, long row) { return x + row * sides<Number>; }

  /// sum -= a x of R numbers `stride` apart and one row of x.
  template <int R>
  [[gnu::always_inline]] static void subtract(Wide (&sum)[R][V], const Number* a, long stride, const Number* x) {
    Wide row[V];
#pragma GCC unroll 8
    for (int v = 0; v < V; ++v) row[v] = load(x + v * lanes);
#pragma GCC unroll 8
    for (int r = 0; r < R; ++r) {
      const Wide factor = a[r * stride] - Wide{};
#pragma GCC unroll 8
      for (int v = 0; v < V; ++v) sum[r][v] -= factor * row[v];
    }
  }
  template <int R>
  [[gnu::always_inline]] static void scale(Wide (&sum)[R][V], int r, Number diagonal, bool is_inverted) {
    const Wide factor = (is_inverted ? diagonal : 1 / diagonal) - Wide{};
#pragma GCC unroll 8
    for (int v = 0; v < V; ++v) sum[r][v] *= factor;
  }
  template <int R>
  [[gnu::always_inline]] static void loadRows(Wide (&sum)[R][V], const Number* x) {
#pragma GCC unroll 8
    for (int r = 0; r < R; ++r)
#pragma GCC unroll 8
      for (int v = 0; v < V; ++v) sum[r][v] = load(x + r * sides<Number> + v * lanes);
  }
  template <int R>
  [[gnu::always_inline]] static void storeRows(const Wide (&sum)[R][V], Number* x) {
#pragma GCC unroll 8
    for (int r = 0; r < R; ++r)
#pragma GCC unroll 8
      for (int v = 0; v < V; ++v) store(x + r * sides<Number> + v * lanes, sum[r][v]);
  }

  /// Rows i to i + R of the triangle's columns.
  template <int R>
  static void forwardOwn(const Panel& p, int i, Number* own) {
    Wide sum[R][V];
    loadRows<R>(sum, at(own, i));
    for (int j = 0; j < i; ++j) subtract<R>(sum, p.triangle + i + long(j) * p.triangle_rows, 1, at(own, j));
    const Number* const corner = p.triangle + i + long(i) * p.triangle_rows;
#pragma GCC unroll 8
    for (int c = 0; c < R; ++c) {
      scale<R>(sum, c, corner[c + long(c) * p.triangle_rows], p.is_inverted);
#pragma GCC unroll 8
      for (int r = c + 1; r < R; ++r) {
        const Wide factor = corner[r + long(c) * p.triangle_rows] - Wide{};
#pragma GCC unroll 8
        for (int v = 0; v < V; ++v) sum[r][v] -= factor * sum[c][v];
      }
    }
    storeRows<R>(sum, at(own, i));
  }
  /// Rows i to i + R of the rest.
  template <int R>
  static void forwardBelow(const Panel& p, int i, const Number* own, Number* x) {
    Wide sum[R][V] = {};
    for (int j = 0; j < p.columns; ++j) subtract<R>(sum, p.rest + i + long(j) * p.rest_rows, 1, own + long(j) * sides<Number>);
#pragma GCC unroll 8
    for (int r = 0; r < R; ++r) {
      Number* const to = at(x, p.rows[i + r]);
#pragma GCC unroll 8
      for (int v = 0; v < V; ++v) store(to + v * lanes, load(to + v * lanes) + sum[r][v]);
    }
  }
  /// Columns j to j + R; those behind are done.
  template <int R>
  static void backwardOwn(const Panel& p, int j, Number* own, Number* x) {
    Wide sum[R][V];
    loadRows<R>(sum, at(own, j));
    const Number* const rest = p.rest + long(j) * p.rest_rows;
    for (int i = 0; i < p.below; ++i) subtract<R>(sum, rest + i, p.rest_rows, at(x, p.rows[i]));
    const Number* const column = p.triangle + long(j) * p.triangle_rows;
    for (int i = j + R; i < p.columns; ++i) subtract<R>(sum, column + i, p.triangle_rows, at(own, i));
#pragma GCC unroll 8
    for (int c = R - 1; c >= 0; --c) {
      scale<R>(sum, c, column[j + c + long(c) * p.triangle_rows], p.is_inverted);
#pragma GCC unroll 8
      for (int r = 0; r < c; ++r) {
        const Wide factor = column[j + c + long(r) * p.triangle_rows] - Wide{};
#pragma GCC unroll 8
        for (int v = 0; v < V; ++v) sum[r][v] -= factor * sum[c][v];
      }
    }
    storeRows<R>(sum, at(own, j));
  }

  /// body(i, R) for tiles of R rows, and of fewer at the end.
  template <class Body>
  [[gnu::always_inline]] static void forTiles(int count, Body&& body) {
    int i = 0;
    for (; i + side_tile <= count; i += side_tile) body.template operator()<side_tile>(i);
    if constexpr (side_tile > 4)
      if (i + 4 <= count) body.template operator()<4>(i), i += 4;
    if constexpr (side_tile > 2)
      if (i + 2 <= count) body.template operator()<2>(i), i += 2;
    for (; i < count; ++i) body.template operator()<1>(i);
  }

  static void forward(const Panel& p, Number* x) {
    Number* const own = at(x, p.first);
    forTiles(p.columns, [&]<int R>(int i) { forwardOwn<R>(p, i, own); });
    forTiles(p.below, [&]<int R>(int i) { forwardBelow<R>(p, i, own, x); });
  }
  static void backward(const Panel& p, Number* x) {
    Number* const own = at(x, p.first);
    // the tiles of forTiles(), counted from the end
    forTiles(p.columns, [&]<int R>(int i) { backwardOwn<R>(p, p.columns - i - R, own, x); });
  }
};

constexpr AllSideKernels side_loops = {{SideLoops<float>::forward, SideLoops<float>::backward},
                                       {SideLoops<double>::forward, SideLoops<double>::backward}};

}  // namespace
}  // namespace stroma
