// SPDX-License-Identifier: LGPL-2.1-or-later
// The tetrahedron of ten nodes at the four points of degree 2 (Hammer and Stroud 1956), free of meshes: point p has the
// volume coordinate l_p = b and the others a. The derivatives along xi, eta, zeta are linear over the element, so that
// with their values at its corners
//   dx/dxi_i at corner v = h_i(v) - h_0(v),   h_w(v) = 4 x_vw - x_w,   h_v(v) = 3 x_v,   x_vw the node between v and w
// those at point p are a sum_v (...)(v) + (b - a) (...)(p). Forces on derivatives go back to nodes by the transpose.
#pragma once
#include "framework/fem/gradients.h"
#include "framework/mesh/cell_kind.h"

namespace stroma::quadratic_tetrahedron {

using namespace elastic;

constexpr int nodes = 10, points = 4;
/// Node number of the middle between two corners.
inline constexpr int middle[4][4] = {{-1, 4, 6, 7}, {4, -1, 5, 8}, {6, 5, -1, 9}, {7, 8, 9, -1}};

/// Derivatives along xi, eta and zeta at the points, the columns of J; or forces on them.
template <class T>
struct PointValues {
  V3<T> d[points][3];
  M3<T> matrix(int p) const { return {d[p][0], d[p][1], d[p][2]}; }
};

/// The same map from values at corners to those at points, and its transpose: it is symmetric.
template <class T>
void betweenCornersAndPoints(PointValues<T>& values) {
  const T low(cell_tables::near_face), step(cell_tables::near_node - cell_tables::near_face);
  for (int i = 0; i < 3; ++i) {
    const V3<T> mean = ((values.d[0][i] + values.d[1][i]) + (values.d[2][i] + values.d[3][i])) * low;
    for (int p = 0; p < points; ++p) values.d[p][i] = fma(step, values.d[p][i], mean);
  }
}
template <class T>
PointValues<T> atPoints(const V3<T> (&x)[nodes]) {
  const T four(4.);
  PointValues<T> out;
  for (int v = 0; v < 4; ++v) {
    V3<T> h[4];
    for (int w = 0; w < 4; ++w) h[w] = v == w ? x[v] * T(3.) : fma(four, x[middle[v][v == w ? 0 : w]], -x[w]);
    for (int i = 0; i < 3; ++i) out.d[v][i] = h[i + 1] - h[0];
  }
  betweenCornersAndPoints(out);
  return out;
}
/// Forces on the nodes.
template <class T>
void nodesOf(PointValues<T> f, V3<T> (&out)[nodes]) {
  betweenCornersAndPoints(f);
  for (V3<T>& force : out) force = {T(0.), T(0.), T(0.)};
  for (int v = 0; v < 4; ++v)
    for (int w = 0; w < 4; ++w) {
      const V3<T> h = w > 0 ? f.d[v][w > 0 ? w - 1 : 0] : -(f.d[v][0] + f.d[v][1] + f.d[v][2]);
      if (v == w)
        out[v] = fma(T(3.), h, out[v]);
      else
        out[w] = out[w] - h, out[middle[v][w]] = fma(T(4.), h, out[middle[v][w]]);
    }
}

/// dN_a/d(xi, eta, zeta) at the points, [point][node].
inline constexpr auto shape_derivatives = [] {
  std::array<std::array<LocalPoint, nodes>, points> table{};
  for (std::size_t p = 0; p < points; ++p)
    cell_kinds::quadratic_tetrahedron.gradients(cell_tables::tetrahedron_4[p].xi, table[p].data());
  return table;
}();
/// The gradient of the shape function of node a at point p, from those of xi, eta and zeta there.
template <class T>
V3<T> nodeGradient(const Gradients<T>& g, int a, int p) {
  const LocalPoint& c = shape_derivatives[std::size_t(p)][std::size_t(a)];
  return fma(T(c[0]), g.g1, fma(T(c[1]), g.g2, g.g3 * T(c[2])));
}

}  // namespace stroma::quadratic_tetrahedron
