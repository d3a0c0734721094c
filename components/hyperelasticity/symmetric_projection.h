// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/fem/pack.h"

namespace stroma {

/// A symmetric matrix a = v diag(a) v^T: its diagonal becomes the eigenvalues, the columns of v the eigenvectors.
/// Cyclic Jacobi rotations, all lanes at once; stops when the rest is round-off in every lane. NaN stays NaN, also
/// one off the diagonal. Numbers must have squares: magnitudes from 1e-140 to 1e140. Not inlined, as it is long; noipa
/// because GCC 12 takes the matrices for unchanged by a call that is only noinline.
template <int n, class T>
[[gnu::noipa]] void diagonalise(T (&a)[n][n], T (&v)[n][n]) {
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) v[i][j] = T(i == j ? 1. : 0.);
  for (int sweep = 0; sweep < 12; ++sweep) {
    T off(0.), diagonal(0.);
    for (int i = 0; i < n; ++i) {
      diagonal = fma(a[i][i], a[i][i], diagonal);
      for (int j = 0; j < i; ++j) off = fma(a[i][j], a[i][j], off);
    }
    if (!any(!(off <= T(1e-30) * diagonal))) break;  // NaN goes on, until it is everywhere
    for (int p = 0; p < n; ++p)
      for (int q = p + 1; q < n; ++q) {
        // t = tan of the angle that makes a[p][q] zero, the smaller of the two
        const auto zero = abs(a[p][q]) <= T(1e-300);
        const T theta = T(0.5) * (a[q][q] - a[p][p]) / select(zero, T(1.), a[p][q]);
        const T root = abs(theta) + sqrt(fma(theta, theta, T(1.)));
        const T t = select(zero, T(0.), select(theta < T(0.), T(-1.), T(1.)) / root);
        const T c = T(1.) / sqrt(fma(t, t, T(1.))), s = t * c;
        const auto rotate = [&](T& x, T& y) {
          const T old = x;
          x = fma(c, old, -s * y), y = fma(s, old, c * y);
        };
        for (int k = 0; k < n; ++k) rotate(a[k][p], a[k][q]);
        for (int k = 0; k < n; ++k) rotate(a[p][k], a[q][k]);
        for (int k = 0; k < n; ++k) rotate(v[k][p], v[k][q]);
      }
  }
}

/// The nearest negative semi-definite matrix of a symmetric one: eigenvalues above zero become zero.
template <int n, class T>
[[gnu::noipa]] void projectNegative(T (&a)[n][n]) {
  T v[n][n];
  diagonalise(a, v);
  T value[n];
  for (int i = 0; i < n; ++i) value[i] = select(a[i][i] > T(0.), T(0.), a[i][i]);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j <= i; ++j) {
      T sum(0.);
      for (int k = 0; k < n; ++k) sum = fma(v[i][k] * value[k], v[j][k], sum);
      a[i][j] = a[j][i] = sum;
    }
}

}  // namespace stroma
