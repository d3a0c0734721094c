// SPDX-License-Identifier: LGPL-2.1-or-later
// Cells of any shape with incompatible modes, for the models of hexahedron_modal.h. The modes are condensed out of each cell at rest
// (hexahedron_incompatible.h), which leaves a K of the 21 numbers of Modes.
#pragma once
#include "components/elasticity/hexahedron_modal.h"
#include "components/elasticity/hexahedron_points.h"

namespace stroma::hexahedron {

/// Any shape: the upper triangle of K, row by row. 1,920 bytes a product. Not inlined: element loops are flattened, and a copy in each
/// takes the compiler long.
struct CondensedCells {
  static constexpr int numbers = 21;
  template <class T>
  struct Rest {
    T inverse_edges[6];  ///< as in PointRest
    Modes<T> modes;      ///< X
    T k[numbers * (numbers + 1) / 2];
  };
  template <class T>
  struct Tangent {
    M3<T> axes;
  };
  template <class T>
  [[gnu::noipa, gnu::flatten]] static Modes<T> product(const Rest<T>& rest, const Tangent<T>&, const T& factor, const Modes<T>& own) {
    T in[numbers], out[numbers];
    int n = 0;
    Modes<T> result{};
    forEachMode(own, result, [&](const V3<T>& v, V3<T>&) { in[n] = v.x, in[n + 1] = v.y, in[n + 2] = v.z, n += 3; });
    for (int i = 0; i < numbers; ++i) out[i] = T(0.);
    const T* k = rest.k;
    for (int i = 0; i < numbers; ++i) {
      T sum = *k++ * in[i];
      for (int j = i + 1; j < numbers; ++j, ++k) sum = fma(*k, in[j], sum), out[j] = fma(*k, in[i], out[j]);
      out[i] = out[i] + sum;
    }
    n = 0;
    const T minus = -factor;
    forEachMode(result, own, [&](V3<T>& v, const V3<T>&) { v = V3<T>{out[n], out[n + 1], out[n + 2]} * minus, n += 3; });
    return result;
  }
  template <class T>
  static Modes<T> displacement(const Rest<T>& rest, const M3<T>& r, const Modes<T>& m) {
    return rotatedBack(r, m) - rest.modes;
  }
  template <class T>
  static M3<T> deformation(const Rest<T>& rest, const Tangent<T>&, const M3<T>& edges) {
    return timesUpper(edges, rest.inverse_edges);
  }
  template <class T>
  static M3<T> restEdges(const Rest<T>& rest) {
    return meanEdges(rest.modes);
  }
};

}  // namespace stroma::hexahedron
