// SPDX-License-Identifier: LGPL-2.1-or-later
// How the best rotation R of A (framework/fem/local_frame.h) turns when A changes.
#pragma once
#include "framework/fem/local_frame.h"

namespace stroma::local_frame {

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

}  // namespace stroma::local_frame
