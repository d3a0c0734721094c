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

/// G^-1 of G = tr(S) I - S, S the symmetric part of R^T A: the spin of R in its own axes is w = G^-1 axial(R^T dA), dR
/// = R [w]x. G is singular where R is not unique; the determinant is then kept from zero.
template <class T>
S3<T> spinInverse(const M3<T>& r, const M3<T>& a) {
  const S3<T> s = rotation::stretch(r, a);
  const T gx = s.yy + s.zz, gy = s.zz + s.xx, gz = s.xx + s.yy;
  S3<T> c;  // cofactors of a symmetric matrix
  c.xx = gy * gz - s.yz * s.yz;
  c.yy = gz * gx - s.zx * s.zx;
  c.zz = gx * gy - s.xy * s.xy;
  c.xy = fma(s.yz, s.zx, s.xy * gz);
  c.yz = fma(s.zx, s.xy, s.yz * gx);
  c.zx = fma(s.xy, s.yz, s.zx * gy);
  const T trace = gx + gy + gz;
  const T determinant = fma(gx, c.xx, -fma(s.xy, c.xy, s.zx * c.zx));
  const T inverse = T(1.) / maximum(determinant, fma(T(1e-9), trace * trace * trace, T(1e-300)));
  return {c.xx * inverse, c.yy * inverse, c.zz * inverse, c.xy * inverse, c.yz * inverse, c.zx * inverse};
}

/// sum_j q_j x e_j of E = sum_j e_j q_j^T.
template <class T>
V3<T> axial(const M3<T>& e) {
  return {e.c1.z - e.c2.y, e.c2.x - e.c0.z, e.c0.y - e.c1.x};
}

}  // namespace local_frame
}  // namespace stroma
