// SPDX-License-Identifier: LGPL-2.1-or-later
// The matrix of a fan of tetrahedra block by block from their gradients: a third of the time that products with unit vectors
// take, as only pairs i <= j are computed. K_ab is the derivative of the force on node a for node b's position.
#pragma once
#include "components/elasticity/element_matrix.h"
#include "components/elasticity/tetrahedron_corotational.h"
#include "framework/fem/tetrahedron_fans.h"

namespace stroma::tetrahedron {

/// K_ab = -(ratio g_a (x) g_b + g_b (x) g_a + (g_a . g_b) I) with the gradients of a tangent.
template <class T>
struct WarpedBlocks {
  V3<T> g[4];
  T ratio;
  WarpedBlocks(const auto&, const auto& t, const V3<T> (&)[4])
      : g{-(t.g.g1 + t.g.g2 + t.g.g3), t.g.g1, t.g.g2, t.g.g3}, ratio(t.ratio) {}
  void add(int a, int b, T (&block)[9]) const {
    addOuter(-ratio, g[a], g[b], block);
    addOuter(T(-1.), g[b], g[a], block);
    const T both = dot(g[a], g[b]);
    block[0] -= both, block[4] -= both, block[8] -= both;
  }
};

/// K_ab = -(lambda m_a (x) m_b + mu m_b (x) m_a + mu (G_a . G_b) F F^T + (G_a . S G_b) I), m_a = F G_a.
template <class T>
struct GreenBlocks {
  V3<T> g[4], m[4], minus_sg[4];
  S3<T> left;  ///< -mu F F^T
  T lambda, mu;
  GreenBlocks(const RestGradients<T>& rest, const Constants<T>& t, const V3<T> (&x)[4])
      : g{-(rest.g.g1 + rest.g.g2 + rest.g.g3), rest.g.g1, rest.g.g2, rest.g.g3}, lambda(t.lambda), mu(t.mu) {
    const M3<T> f = outerSum(Edges(x).e, rest.g), r = transpose(f);
    const S3<T> minus_s = restoringStress(greenStrain(f, T(1.)), lambda, mu);
    for (int a = 0; a < 4; ++a) m[a] = f * g[a], minus_sg[a] = minus_s * g[a];
    left = S3<T>{dot(r.c0, r.c0), dot(r.c1, r.c1), dot(r.c2, r.c2), dot(r.c0, r.c1), dot(r.c1, r.c2), dot(r.c2, r.c0)} * -mu;
  }
  void add(int a, int b, T (&block)[9]) const {
    addOuter(-lambda, m[a], m[b], block);
    addOuter(-mu, m[b], m[a], block);
    const T both = dot(g[a], g[b]), held = dot(g[a], minus_sg[b]);
    const S3<T> own{fma(both, left.xx, held), fma(both, left.yy, held), fma(both, left.zz, held),
                    both * left.xy,           both * left.yz,           both * left.zx};
    const T symmetric[9] = {own.xx, own.xy, own.zx, own.xy, own.yy, own.yz, own.zx, own.yz, own.zz};
    for (int e = 0; e < 9; ++e) block[e] += symmetric[e];
  }
};

/// K of a fan as FanOf::matrix() gives it, but that blocks of nodes that share no tetrahedron are zero. `Blocks`: one of the
/// above.
template <class Blocks>
void fanMatrix(const auto& rest, const auto& t, const V3<Pack> (&x)[fan_nodes], Pack (&k)[fan_nodes * fan_nodes * 9]) {
  const V3<Pack> second_x[4] = {x[0], x[1], x[3], x[4]}, first_x[4] = {x[0], x[1], x[2], x[3]};
  const Blocks first(rest.of[0], t.of[0], first_x), second(rest.of[1], t.of[1], second_x);
#pragma GCC unroll 5
  for (int i = 0; i < fan_nodes; ++i)
#pragma GCC unroll 5
    for (int j = i; j < fan_nodes; ++j) {
      Pack block[9];
      for (Pack& value : block) value = Pack(0.);
      if (j < 4) first.add(i, j, block);
      if (i != 2 && j != 2) second.add(i - (i > 2), j - (j > 2), block);
      Pack *upper = k + (i * fan_nodes + j) * 9, *lower = k + (j * fan_nodes + i) * 9;
#pragma GCC unroll 9
      for (int e = 0; e < 9; ++e) upper[e] = lower[e % 3 * 3 + e / 3] = block[e];
    }
}

}  // namespace stroma::tetrahedron
