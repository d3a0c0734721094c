// SPDX-License-Identifier: LGPL-2.1-or-later
// Rotations from a deformation gradient F: always orthonormal and right-handed, for |F| up to 1e150. T is a Pack or a
// double.
// Source: Irving et al. 2004 for the inverted case; Higham 1986 for the iteration.
#pragma once
#include "framework/fem/pack.h"

namespace stroma::rotation {

/// A unit vector along v; `fallback` (a unit vector) where v is shorter than 1e-12.
template <class T>
V3<T> unit(const V3<T>& v, const V3<T>& fallback) {
  const T squared = dot(v, v);
  const auto degenerate = squared < T(1e-24);
  return select(degenerate, fallback, v * reciprocalSqrt(select(degenerate, T(1.), squared)));
}

/// Some unit vector across the unit vector a.
template <class T>
V3<T> across(const V3<T>& a) {
  const auto along_x = abs(a.x) > T(0.9);
  const V3<T> axis = select(along_x, V3<T>{T(0.), T(1.), T(0.)}, V3<T>{T(1.), T(0.), T(0.)});
  const V3<T> v = cross(a, axis);
  return v * reciprocalSqrt(dot(v, v));
}

/// The frame of two columns that are nearly parallel, very long or very short: made orthogonal twice; parallel ones get
/// some plane.
template <class T>
M3<T> narrowFrame(const V3<T>& a, const V3<T>& b) {
  M3<T> r;
  r.c0 = unit(a, V3<T>{T(1.), T(0.), T(0.)});
  const V3<T> other = across(r.c0);
  const V3<T> rough = unit(fma(-dot(r.c0, b), r.c0, b), other);
  r.c1 = unit(fma(-dot(r.c0, rough), r.c0, rough), other);
  r.c2 = cross(r.c0, r.c1);
  return r;
}

/// Gram-Schmidt on the columns: first axis along c0, second in the plane of c0 and c1, third their cross product. The
/// part of c1 across c0 is taken |c0|^2 times as long, so that its length need not wait for that of c0: how long the
/// chain of operations is, not how many they are, is what this costs.
template <class T>
M3<T> gramSchmidt(const M3<T>& f) {
  const T first = dot(f.c0, f.c0), second = dot(f.c1, f.c1), along = dot(f.c0, f.c1);
  const V3<T> in_plane{fma(first, f.c1.x, -along * f.c0.x), fma(first, f.c1.y, -along * f.c0.y),
                       fma(first, f.c1.z, -along * f.c0.z)};
  const T squared = dot(in_plane, in_plane), weight = first * first;
  const auto plain = squared > weight * maximum(T(0.01) * second, T(1e-24)) && first > T(1e-24) && squared < T(1e290);
  M3<T> r;
  r.c0 = f.c0 * reciprocalSqrt(first);
  r.c1 = in_plane * reciprocalSqrt(squared);
  r.c2 = cross(r.c0, r.c1);
  return any(!plain) ? select(plain, r, narrowFrame(f.c0, f.c1)) : r;
}

/// The nearest orthogonal matrix to F (a reflection when det F < 0): the Newton iteration Q <- (gamma Q + (gamma Q)^-T)
/// / 2, whose singular values are at least 1 after the first step and fall to 1 quadratically. gamma (the scaling of
/// Higham 1986) only matters while Q is far from orthogonal. A flat F (rank 2) gives its rotation in the limit; lanes
/// crushed to a line or a point get the Gram-Schmidt frame.
template <class T>
M3<T> orthogonalFactor(const M3<T>& f) {
  M3<T> q = f;
  M3<T> c = cofactor(q);
  T size = squaredNorm(q);
  const auto crushed = squaredNorm(c) <= size * size * T(1e-28) || size < T(1e-200);
  if (any(crushed)) {
    q = select(crushed, gramSchmidt(f), q);
    c = cofactor(q);
    size = squaredNorm(q);
  }
  bool close = false;
  for (int iteration = 0; iteration < 40; ++iteration) {
    T determinant = dot(q.c0, c.c0);
    const auto flat = determinant * determinant < size * size * size * T(1e-40);
    // a flat element has determinant zero: any tiny number in its place leads to the same limit
    if (any(flat)) {
      const T floor = size * sqrt(size) * T(1e-20);
      determinant = select(flat, select(determinant < T(0.), -floor, floor), determinant);
    }
    const T inverse = T(1.) / determinant;
    T a(0.5), b = T(0.5) * inverse;
    if (any(abs(size - T(3.)) > T(0.1))) {
      const T gamma = roughFourthRoot(squaredNorm(c) * inverse * inverse / size);
      a = a * gamma;
      b = b / gamma;
    }
    q = {fma(a, q.c0, c.c0 * b), fma(a, q.c1, c.c1 * b), fma(a, q.c2, c.c2 * b)};
    if (close) break;
    // |Q|^2 - 3 is about twice the error, and a step squares the error: below 3e-8 one more step reaches round-off
    size = squaredNorm(q);
    close = !any(size > T(3. + 3e-8));
    c = cofactor(q);
  }
  return q;
}

/// S = R^T F, the lower triangle taken from the symmetric part.
template <class T>
S3<T> stretch(const M3<T>& r, const M3<T>& f) {
  const T half(0.5);
  return {dot(r.c0, f.c0),
          dot(r.c1, f.c1),
          dot(r.c2, f.c2),
          half * (dot(r.c0, f.c1) + dot(r.c1, f.c0)),
          half * (dot(r.c1, f.c2) + dot(r.c2, f.c1)),
          half * (dot(r.c2, f.c0) + dot(r.c0, f.c2))};
}

/// The unit eigenvector of the smallest eigenvalue of a symmetric matrix: cyclic Jacobi, five sweeps (the off-diagonal
/// part shrinks to round-off cubically after the second).
template <class T>
V3<T> smallestEigenvector(const S3<T>& s) {
  T a[3][3] = {{s.xx, s.xy, s.zx}, {s.xy, s.yy, s.yz}, {s.zx, s.yz, s.zz}};
  T v[3][3] = {{T(1.), T(0.), T(0.)}, {T(0.), T(1.), T(0.)}, {T(0.), T(0.), T(1.)}};
  for (int sweep = 0; sweep < 5; ++sweep)
    for (int p = 0; p < 2; ++p)
      for (int q = p + 1; q < 3; ++q) {
        const int r = 3 - p - q;
        const T apq = a[p][q];
        const auto none = abs(apq) < T(1e-300);
        const T theta = (a[q][q] - a[p][p]) / (T(2.) * select(none, T(1.), apq));
        T t = T(1.) / (abs(theta) + sqrt(theta * theta + T(1.)));
        t = select(none, T(0.), select(theta < T(0.), -t, t));
        const T cosine = T(1.) / sqrt(t * t + T(1.)), sine = t * cosine;
        a[p][p] = a[p][p] - t * apq;
        a[q][q] = a[q][q] + t * apq;
        a[p][q] = a[q][p] = T(0.);
        const T arp = a[r][p], arq = a[r][q];
        a[r][p] = a[p][r] = cosine * arp - sine * arq;
        a[r][q] = a[q][r] = sine * arp + cosine * arq;
        for (auto& row : v) {
          const T vp = row[p], vq = row[q];
          row[p] = cosine * vp - sine * vq;
          row[q] = sine * vp + cosine * vq;
        }
      }
  const auto column = [&](int k) { return V3<T>{v[0][k], v[1][k], v[2][k]}; };
  const auto second = a[1][1] < a[0][0];
  const V3<T> best = select(second, column(1), column(0));
  const T least = select(second, a[1][1], a[0][0]);
  return select(a[2][2] < least, column(2), best);
}

/// r [omega]x
template <class T>
M3<T> timesCross(const M3<T>& r, const V3<T>& w) {
  return {r.c1 * w.z - r.c2 * w.y, r.c2 * w.x - r.c0 * w.z, r.c0 * w.y - r.c1 * w.x};
}

/// R = U V^T of F = U diag(s) V^T with the smallest singular value taken negative when det F < 0, the smallest inversion
/// (Irving et al. 2004): the nearest rotation for every F. Only the lanes that are inverted need the direction of the
/// smallest singular value.
template <class T>
M3<T> nearest(const M3<T>& f) {
  const M3<T> q = orthogonalFactor(f);
  const auto reflected = dot(q.c0, cross(q.c1, q.c2)) < T(0.);
  if (!any(reflected)) return q;
  const V3<T> v = smallestEigenvector(stretch(q, f));
  const V3<T> qv = (q * v) * T(2.);
  return select(reflected, M3<T>{fma(-v.x, qv, q.c0), fma(-v.y, qv, q.c1), fma(-v.z, qv, q.c2)}, q);
}

}  // namespace stroma::rotation
