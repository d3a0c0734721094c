// SPDX-License-Identifier: LGPL-2.1-or-later
// L Y = B and L^T X = Y of a supernode for many right sides at once, once for each instruction set: numbers of the factor are read once
// for all of them. Plain C types only, as in front_kernels.h.
#pragma once

namespace stroma {

/// Right sides that go through a factor at once: two cache lines of numbers.
template <class Number>
constexpr int sides = 128 / int(sizeof(Number));

/// The columns of a supernode: a triangle and the rest below it, by columns.
template <class Number>
struct SidePanel {
  int first, columns, below;             ///< its first column; how many; rows below the triangle
  const Number *triangle, *rest;
  int triangle_rows, rest_rows;          ///< how long columns are
  const int* rows;                       ///< of the rest, among all columns
  bool is_inverted;                      ///< the diagonal holds 1 / L_ii
};

/// x: of all columns, shape (columns, sides). What a column of x becomes does not depend on the others.
template <class Number>
struct SideKernels {
  void (*forward)(const SidePanel<Number>& panel, Number* x);
  void (*backward)(const SidePanel<Number>& panel, Number* x);
};

struct AllSideKernels {
  SideKernels<float> in_single;
  SideKernels<double> in_double;
};
extern const AllSideKernels side_kernels_v2, side_kernels_v3, side_kernels_v4;

}  // namespace stroma
