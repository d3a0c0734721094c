// SPDX-License-Identifier: LGPL-2.1-or-later
// One integration point, whatever the element. It has three difference vectors d_1, d_2, d_3 (edges of a tetrahedron,
// derivatives along the axes of a hexahedron) and three gradients g_1, g_2, g_3 such that the displacement gradient is
// H = sum d_i (x) g_i.
#pragma once
#include "framework/fem/pack.h"

namespace stroma::elastic {

/// Gradients g_1, g_2, g_3 [1/m].
template <class T>
struct Gradients {
  V3<T> g1, g2, g3;
};

/// sum d_i (x) g_i, columns.
template <class T>
M3<T> outerSum(const V3<T> (&d)[3], const Gradients<T>& g) {
  return {fma(g.g1.x, d[0], fma(g.g2.x, d[1], d[2] * g.g3.x)), fma(g.g1.y, d[0], fma(g.g2.y, d[1], d[2] * g.g3.y)),
          fma(g.g1.z, d[0], fma(g.g2.z, d[1], d[2] * g.g3.z))};
}

/// M S
template <class T>
M3<T> timesSymmetric(const M3<T>& m, const S3<T>& s) {
  return {fma(s.xx, m.c0, fma(s.xy, m.c1, m.c2 * s.zx)), fma(s.xy, m.c0, fma(s.yy, m.c1, m.c2 * s.yz)),
          fma(s.zx, m.c0, fma(s.yz, m.c1, m.c2 * s.zz))};
}

}  // namespace stroma::elastic
