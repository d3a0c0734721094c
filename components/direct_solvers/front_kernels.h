// SPDX-License-Identifier: LGPL-2.1-or-later
// Dense operations on the fronts of a sparse factorisation, once for each instruction set. Fronts have 10 to 100 columns: the
// BLAS spends more on each call than on the numbers. Plain C types only: code compiled for wide registers must share no
// inline function with the rest of the program.
//
// Matrices are stored by columns, from 64-byte boundaries, and columns are front_rows long or a multiple of it. What is beyond the
// last row is computed with, and may hold anything finite.
#pragma once

namespace stroma {

constexpr int front_rows = 16;     ///< columns are padded to a multiple of it
constexpr int front_columns = 96;  ///< of a triangle or a depth at most, see below

/// Rows from `from` on of an update are those from `to` on of the parent's front.
struct FrontRun {
  int from, to, count;
};

/// A front with n columns and m rows below them: its columns as a triangle of n rows and the rest of m rows, and the update of
/// what is below, shape (m, m).
struct FrontParts {
  int columns, below, triangle_rows, below_rows;  ///< n, m, and the two padded: how long columns are
  float *triangle, *rest, *update;
};

struct FrontKernels {
  /// A = L L^T of the lower triangle of a, shape (n, n); n <= front_columns. The diagonal gets 1 / L_ii. Returns the first column
  /// without a positive pivot, -1 when all have one.
  int (*factor)(float* a, int lda, int n);
  /// B <- B L^-T with a triangle as factor() leaves it; B has `rows` rows.
  void (*solveRows)(const float* l, int ldl, int n, float* b, int ldb, int rows);
  /// C -= A B^T, or C = -A B^T where it is fresh; A has `rows` rows, B `columns` rows and both `depth` columns.
  void (*subtract)(const float* a, int lda, int rows, const float* b, int ldb, int columns, int depth, bool is_fresh, float* c,
                   int ldc);
  /// The lower triangle of C -= A A^T, or of C = -A A^T, shape (n, n). What is above it becomes anything.
  void (*subtractLower)(const float* a, int lda, int n, int depth, bool is_fresh, float* c, int ldc);
  /// Adds the update of a child to columns `first` to `last` of its parent's front. No run goes across the parent's columns.
  void (*add)(const FrontParts& child, const FrontRun* begin, const FrontRun* end, const FrontParts& parent, int first,
              int last);
  /// y -= A x, shape (rows, columns); y = A^T x.
  void (*subtractProduct)(const float* a, int lda, int rows, int columns, const float* x, float* y);
  void (*subtractTransposed)(const float* a, int lda, int rows, int columns, const float* x, float* y);
  /// L x = b and L^T x = b in place with triangles of any n whose diagonal is inverted.
  void (*solveForward)(const float* l, int ldl, int n, float* x);
  void (*solveBackward)(const float* l, int ldl, int n, float* x);
};

extern const FrontKernels front_kernels_v2, front_kernels_v3, front_kernels_v4;

}  // namespace stroma
