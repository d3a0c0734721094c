// SPDX-License-Identifier: LGPL-2.1-or-later
// What hyperelastic laws need of matrices: contractions, the metric F^T F, and a 4th-order elasticity in Voigt's order.
#pragma once
#include "components/hyperelasticity/hyperelastic_jet.h"
#include "framework/fem/gradients.h"

namespace stroma::hyperelastic {

using elastic::timesSymmetric;

template <class T>
M3<T> cofactorDifferential(const M3<T>& f, const M3<T>& df) {
  return {cross(df.c1, f.c2) + cross(f.c1, df.c2), cross(df.c2, f.c0) + cross(f.c2, df.c0),
          cross(df.c0, f.c1) + cross(f.c0, df.c1)};
}
template <class T>
T dot(const M3<T>& a, const M3<T>& b) {
  return stroma::dot(a.c0, b.c0) + stroma::dot(a.c1, b.c1) + stroma::dot(a.c2, b.c2);
}
/// a : b of symmetric matrices.
template <class T>
T dot(const S3<T>& a, const S3<T>& b) {
  const T shear = fma(a.xy, b.xy, fma(a.yz, b.yz, a.zx * b.zx));
  return fma(a.xx, b.xx, fma(a.yy, b.yy, fma(a.zz, b.zz, shear + shear)));
}
/// F^T F
template <class T>
S3<T> metric(const M3<T>& f) {
  using stroma::dot;
  return {dot(f.c0, f.c0), dot(f.c1, f.c1), dot(f.c2, f.c2), dot(f.c0, f.c1), dot(f.c1, f.c2), dot(f.c2, f.c0)};
}
/// F^T dF + dF^T F
template <class T>
S3<T> metricDifferential(const M3<T>& f, const M3<T>& df) {
  const auto twice = [](const V3<T>& a, const V3<T>& da) { return T(2.) * stroma::dot(a, da); };
  const auto both = [](const V3<T>& a, const V3<T>& da, const V3<T>& b, const V3<T>& db) {
    return fma(a.x, db.x, fma(a.y, db.y, fma(a.z, db.z, stroma::dot(da, b))));
  };
  return {twice(f.c0, df.c0),
          twice(f.c1, df.c1),
          twice(f.c2, df.c2),
          both(f.c0, df.c0, f.c1, df.c1),
          both(f.c1, df.c1, f.c2, df.c2),
          both(f.c2, df.c2, f.c0, df.c0)};
}
template <class T>
S3<T> unit() {
  S3<T> s;
  s.xx = s.yy = s.zz = T(1.);
  return s;
}

/// A 4 d2W/dC2 in Voigt's order xx yy zz xy yz zx, on strains with doubled shear: dS = D dE.
template <class T>
struct Elasticity {
  T d[6][6];
};
template <class T>
void list(const S3<T>& a, T (&out)[6]) {
  out[0] = a.xx, out[1] = a.yy, out[2] = a.zz, out[3] = a.xy, out[4] = a.yz, out[5] = a.zx;
}
/// D += s (A (x) B + B (x) A) / 2
template <class T>
void addOuter(T s, const S3<T>& a, const S3<T>& b, Elasticity<T>& out) {
  T l[6], r[6];
  list(a, l), list(b, r);
  const T half = T(0.5) * s;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) out.d[i][j] = fma(half, fma(l[i], r[j], l[j] * r[i]), out.d[i][j]);
}
template <class S, class T>
void addOuterUnlessZero(const S& s, const S3<T>& a, const S3<T>& b, Elasticity<T>& out) {
  if constexpr (NotZero<S>) addOuter(T(s), a, b, out);
}

}  // namespace stroma::hyperelastic
