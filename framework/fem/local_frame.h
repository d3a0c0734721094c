// SPDX-License-Identifier: LGPL-2.1-or-later
// The rotation of a point set: the best fit of rest positions q_j to current ones p_j (both from their centroids),
//   R = argmax tr(R^T A),  A = sum_j p_j q_j^T   over rotations (never a reflection),
// for points that may be coplanar, collinear or one. T is a Pack or a double.
#pragma once
#include "framework/fem/rotation.h"

namespace stroma {

namespace local_frame {

/// About 1 / sigma_1 of A, never more: two Newton steps from above on the characteristic polynomial of A^T A.
template <class T>
T inverseLargestSingularValue(const M3<T>& a, const M3<T>& cofactors) {
  const T i1 = squaredNorm(a), i2 = squaredNorm(cofactors), determinant = dot(a.c0, cofactors.c0);
  const auto nothing = i1 < T(1e-200);
  T lambda = select(nothing, T(1.), i1);
  for (int step = 0; step < 2; ++step) {
    const T value = fma(fma(lambda - i1, lambda, i2), lambda, -determinant * determinant);
    const T slope = fma(fma(T(3.), lambda, T(-2.) * i1), lambda, i2);
    lambda = lambda - value / select(nothing, T(1.), slope);
  }
  return select(nothing, T(0.), reciprocalSqrt(lambda));
}

/// A and its cofactor matrix share their singular vectors. With A = U diag(s1, s2, s3) V^T, s3 negative in an inverted
/// set, A + cof(A) / s1 has the positive singular values s1 + s2 s3 / s1, s2 + s3, s2 + s3 once more: its polar factor
/// is the rotation sought, also for a flat set, whose own determinant says nothing about its sign.
template <class T>
M3<T> spread(const M3<T>& a) {
  const M3<T> c = cofactor(a);
  const T scale = inverseLargestSingularValue(a, c);
  return {fma(scale, c.c0, a.c0), fma(scale, c.c1, a.c1), fma(scale, c.c2, a.c2)};
}

/// Best rotation of A. Points on a line leave the turn about it open: it is the one nearest to the rest orientation.
template <class T>
M3<T> bestRotation(const M3<T>& a) {
  const T size = squaredNorm(a);
  const auto line = squaredNorm(cofactor(a)) < size * size * T(1e-20);
  M3<T> r = rotation::nearest(spread(a));
  if (!any(line)) return r;
  const T little = T(1e-6) * sqrt(size);
  M3<T> towards = identity<T>();
  for (int repeat = 0; repeat < 3; ++repeat) towards = rotation::nearest(spread(a + towards * little));
  return select(line, towards, r);
}

}  // namespace local_frame
}  // namespace stroma
