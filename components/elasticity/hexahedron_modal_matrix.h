// SPDX-License-Identifier: LGPL-2.1-or-later
// The stiffness matrix of a hexahedron whose K acts on modes.
#pragma once
#include "components/elasticity/element_matrix.h"
#include "components/elasticity/hexahedron_modes.h"

namespace stroma::hexahedron {

/// K_ab = sum over modes m, n of m(s_a) n(s_b) R K_mn R^T, [a][b][row][column]. Columns of K on modes, x y z of each, are in the axes R of
/// the cell. Not inlined: element loops are flattened, and a copy in each takes the compiler long.
template <class T>
[[gnu::noipa, gnu::flatten]] void matrixOfModes(const Modes<T> (&columns)[21], const M3<T>& r, T (&k)[8 * 8 * 9]) {
  V3<T> at[8][21];  // R K of node a by each number of the modes
  for (int i = 0; i < 21; ++i) {
    V3<T> nodes[8];
    nodesOf(columns[i], nodes);
    for (int a = 0; a < 8; ++a) at[a][i] = r * nodes[a];
  }
  for (int a = 0; a < 8; ++a) {
    const auto add = [&](const T& x, const T& y, const T& z, int column) {  // a row of R
      Modes<T> sums{};
      int i = 0;
      forEachMode(sums, sums, [&](V3<T>& sum, V3<T>&) { sum = fma(x, at[a][i], fma(y, at[a][i + 1], at[a][i + 2] * z)), i += 3; });
      V3<T> nodes[8];
      nodesOf(sums, nodes);
      for (int b = 0; b < 8; ++b) {
        T* const block = k + (a * 8 + b) * 9 + column;
        block[0] = nodes[b].x, block[3] = nodes[b].y, block[6] = nodes[b].z;
      }
    };
    add(r.c0.x, r.c1.x, r.c2.x, 0), add(r.c0.y, r.c1.y, r.c2.y, 1), add(r.c0.z, r.c1.z, r.c2.z, 2);
  }
}

/// The mode of number i, x y z of each.
template <class T>
Modes<T> unitMode(int i) {
  Modes<T> unit{};
  int first = 0;
  forEachMode(unit, unit, [&](V3<T>& v, V3<T>&) {
    if (i - first == 0) v.x = T(1.);
    if (i - first == 1) v.y = T(1.);
    if (i - first == 2) v.z = T(1.);
    first += 3;
  });
  return unit;
}

}  // namespace stroma::hexahedron
