// SPDX-License-Identifier: LGPL-2.1-or-later
// The stiffness matrix of a hexahedron at the 2x2x2 Gauss points (element_matrix.h).
#pragma once
#include "components/elasticity/element_matrix.h"
#include "components/elasticity/hexahedron_law.h"

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

/// All of them.
template <class T>
void nodeGradients(const Gradients<T> (&g)[8], NodeGradients<8, 8, T>& n) {
  for (int p = 0; p < 8; ++p)
    for (int a = 0; a < 8; ++a) n[a][p] = nodeGradient(g[p], a, p);
}

/// K of small strains with the gradients g of each Gauss point. Not inlined, nor the others: element loops are
/// flattened, and a copy in each of two dozen takes the compiler minutes.
template <class T>
__attribute__((noipa, flatten)) void stiffnessMatrix(const Gradients<T> (&g)[8], T lambda, T mu, T (&k)[8 * 8 * 9]) {
  NodeGradients<8, 8, T> n;
  nodeGradients(g, n);
  smallStrainMatrix(n, lambda, mu, k);
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

/// K of St. Venant-Kirchhoff.
template <class T>
__attribute__((noipa, flatten)) void greenMatrix(const Gradients<T> (&g)[8], const GreenState<T> (&state)[8], T lambda,
                                                 T mu, T (&k)[8 * 8 * 9]) {
  NodeGradients<8, 8, T> n;
  nodeGradients(g, n);
  greenStrainMatrix(n, state, lambda, mu, k);
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
