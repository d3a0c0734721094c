// SPDX-License-Identifier: LGPL-2.1-or-later
// The stiffness matrix of a hexahedron, block by block: sums over the Gauss points stay in registers, and only the
// pairs a <= b are computed. With n_a the gradient of node a's shape function (times the root of the point's weight),
//   K_ab = -sum_p [ lambda n_a (x) n_b + mu n_b (x) n_a + mu (n_a . n_b) I ]
//   K_ab = -sum_p [ lambda m_a (x) m_b + mu m_b (x) m_a + mu (n_a . n_b) F F^T + (n_a . S n_b) I ],   m_a = F n_a
// for small strains and for St. Venant-Kirchhoff.
#pragma once
#include "framework/fem/hexahedron.h"

namespace stroma::hexahedron {

/// 8 dN_a/d(xi, eta, zeta) at Gauss point p.
constexpr std::array<double, 3> shapeDerivatives(int a, int p) {
  const auto sign = [](int bit) { return bit & 1 ? 1. : -1.; };
  const double s[3] = {sign(a ^ a >> 1), sign(a >> 1), sign(a >> 2)};  // the order of VTK
  const double at[3] = {1 + s[0] * sign(p) * gauss, 1 + s[1] * sign(p >> 1) * gauss, 1 + s[2] * sign(p >> 2) * gauss};
  return {s[0] * at[1] * at[2], s[1] * at[2] * at[0], s[2] * at[0] * at[1]};
}
/// The same as a table made by the compiler.
inline constexpr auto shape_derivatives = [] {
  std::array<std::array<std::array<double, 3>, 8>, 8> table{};  // [point][node]
  for (int p = 0; p < 8; ++p)
    for (int a = 0; a < 8; ++a) table[p][a] = shapeDerivatives(a, p);
  return table;
}();

/// n_a at Gauss point p.
template <class T>
V3<T> nodeGradient(const Gradients<T>& g, int a, int p) {
  const auto& c = shape_derivatives[p][a];
  return fma(T(c[0]), g.g1, fma(T(c[1]), g.g2, g.g3 * T(c[2])));
}

/// Adds s a (x) b, row-major.
template <class T>
void addOuter(T s, const V3<T>& a, const V3<T>& b, T (&block)[9]) {
  const T left[3] = {s * a.x, s * a.y, s * a.z}, right[3] = {b.x, b.y, b.z};
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) block[3 * r + c] = fma(left[r], right[c], block[3 * r + c]);
}

/// k[a][b][row][column] from add(a, b, block), which adds K_ab for a <= b to zeros.
template <class T, class AddBlock>
void fillSymmetric(T (&k)[8 * 8 * 9], AddBlock&& add) {
  for (int a = 0; a < 8; ++a)
    for (int b = a; b < 8; ++b) {
      T block[9] = {T(0.), T(0.), T(0.), T(0.), T(0.), T(0.), T(0.), T(0.), T(0.)};
      add(a, b, block);
      T *upper = k + (a * 8 + b) * 9, *lower = k + (b * 8 + a) * 9;
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) upper[3 * r + c] = lower[3 * c + r] = block[3 * r + c];
    }
}

/// K of small strains with the gradients g of each Gauss point. Not inlined, nor the others: element loops are
/// flattened, and a copy in each of two dozen takes the compiler minutes.
template <class T>
__attribute__((noipa, flatten)) void stiffnessMatrix(const Gradients<T> (&g)[8], T lambda, T mu, T (&k)[8 * 8 * 9]) {
  V3<T> n[8][8];  // [node][point]
  for (int p = 0; p < 8; ++p)
    for (int a = 0; a < 8; ++a) n[a][p] = nodeGradient(g[p], a, p);
  const T minus_lambda = -lambda, minus_mu = -mu;
  fillSymmetric(k, [&](int a, int b, T(&block)[9]) {
    T shear(0.);
    for (int p = 0; p < 8; ++p) {
      addOuter(minus_lambda, n[a][p], n[b][p], block);
      addOuter(minus_mu, n[b][p], n[a][p], block);
      shear = fma(minus_mu, stroma::dot(n[a][p], n[b][p]), shear);
    }
    block[0] += shear, block[4] += shear, block[8] += shear;
  });
}

/// K -= bulk n_a (x) n_b: the part of a mean dilatation whose derivative at node a is n_a.
template <class T>
void addSquare(const V3<T> (&n)[8], T bulk, T (&k)[8 * 8 * 9]) {
  for (int a = 0; a < 8; ++a)
    for (int b = 0; b < 8; ++b) {
      const T left[3] = {-bulk * n[a].x, -bulk * n[a].y, -bulk * n[a].z}, right[3] = {n[b].x, n[b].y, n[b].z};
      T* block = k + (a * 8 + b) * 9;
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) block[3 * r + c] = fma(left[r], right[c], block[3 * r + c]);
    }
}
/// Small strains: n_a is the sum of root n_a over the Gauss points.
template <class T>
__attribute__((noipa, flatten)) void addMeanMatrix(const Gradients<T> (&g)[8], const T (&root)[8], T bulk,
                                                   T (&k)[8 * 8 * 9]) {
  V3<T> n[8];
  for (int a = 0; a < 8; ++a)
    for (int p = 0; p < 8; ++p) n[a] = fma(root[p], nodeGradient(g[p], a, p), n[a]);
  addSquare(n, bulk, k);
}

/// A Gauss point of St. Venant-Kirchhoff: F with the root of its weight w, -S, and 1/w.
template <class T>
struct GreenState {
  M3<T> f;
  S3<T> minus_s;
  T inverse_weight;
};

/// K of St. Venant-Kirchhoff.
template <class T>
__attribute__((noipa, flatten)) void greenMatrix(const Gradients<T> (&g)[8], const GreenState<T> (&state)[8], T lambda,
                                                 T mu, T (&k)[8 * 8 * 9]) {
  V3<T> n[8][8], m[8][8];  // [node][point]
  S3<T> left_cauchy_green[8];
  for (int p = 0; p < 8; ++p) {
    const M3<T> f = transpose(state[p].f);  // columns: rows of F
    left_cauchy_green[p] = {stroma::dot(f.c0, f.c0), stroma::dot(f.c1, f.c1), stroma::dot(f.c2, f.c2),
                            stroma::dot(f.c0, f.c1), stroma::dot(f.c1, f.c2), stroma::dot(f.c2, f.c0)};
    for (int a = 0; a < 8; ++a) n[a][p] = nodeGradient(g[p], a, p), m[a][p] = state[p].f * n[a][p];
  }
  fillSymmetric(k, [&](int a, int b, T(&block)[9]) {
    T geometric(0.);
    S3<T> sum;
    for (int p = 0; p < 8; ++p) {
      const T minus_mu = -mu * state[p].inverse_weight;
      addOuter(-lambda * state[p].inverse_weight, m[a][p], m[b][p], block);
      addOuter(minus_mu, m[b][p], m[a][p], block);
      geometric += stroma::dot(n[a][p], state[p].minus_s * n[b][p]);
      const T s = minus_mu * stroma::dot(n[a][p], n[b][p]);
      const S3<T>& c = left_cauchy_green[p];
      sum = {fma(s, c.xx, sum.xx), fma(s, c.yy, sum.yy), fma(s, c.zz, sum.zz),
             fma(s, c.xy, sum.xy), fma(s, c.yz, sum.yz), fma(s, c.zx, sum.zx)};
    }
    const T symmetric[9] = {sum.xx + geometric, sum.xy, sum.zx, sum.xy, sum.yy + geometric, sum.yz, sum.zx, sum.yz,
                            sum.zz + geometric};
    for (int i = 0; i < 9; ++i) block[i] += symmetric[i];
  });
}

/// The mean dilatation of St. Venant-Kirchhoff: n_a is the sum of F n_a.
template <class T>
__attribute__((noipa, flatten)) void addMeanMatrix(const Gradients<T> (&g)[8], const GreenState<T> (&state)[8], T bulk,
                                                   T (&k)[8 * 8 * 9]) {
  V3<T> n[8];
  for (int a = 0; a < 8; ++a)
    for (int p = 0; p < 8; ++p) n[a] = n[a] + state[p].f * nodeGradient(g[p], a, p);
  addSquare(n, bulk, k);
}

}  // namespace stroma::hexahedron
