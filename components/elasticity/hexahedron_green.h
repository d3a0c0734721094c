// SPDX-License-Identifier: LGPL-2.1-or-later
// method = green of hexahedra: St. Venant-Kirchhoff, no rotation. Gradients hold w^1/2 / 8, so that F is w^1/2 F.
#pragma once
#include "components/elasticity/green_model.h"
#include "components/elasticity/hexahedron_matrix.h"
#include "components/elasticity/hexahedron_rest.h"

namespace stroma::hexahedron {

/// What the shapes of green_model.h share here.
struct GaussShape {
  static constexpr int nodes = 8, points = 8;
  template <class T>
  static PointValues<T> at(const V3<T> (&x)[8]) {
    return atPoints(modesOf(x));
  }
  template <class T>
  static void toNodes(const PointValues<T>& forces, V3<T> (&f)[8]) {
    nodesOf(fromPoints(forces), f);
  }
  template <class T>
  static void matrixOf(const Gradients<T> (&g)[8], const GreenState<T> (&state)[8], T lambda, T mu, T (&k)[8 * 8 * 9]) {
    greenMatrix(g, state, lambda, mu, k);
  }
  template <class T>
  static void addMeanMatrixOf(const Gradients<T> (&g)[8], const GreenState<T> (&state)[8], T bulk, T (&k)[8 * 8 * 9]) {
    addMeanMatrix(g, state, bulk, k);
  }
};

/// Gauss points of any shape.
struct PointShape : GaussShape {
  template <class T>
  using Rest = PointRest<T>;
  template <class T>
  struct Tangent {
    T lambda, mu;  ///< Lame's constants, or -2/3 mu and mu [Pa]
    T bulk;        ///< K/V, or zero without the mean dilatation [Pa/m^3]
  };
  /// 1/w of Gauss point p [1/m^3].
  template <class T>
  static T inverseWeight(const PointRest<T>& rest, const Tangent<T>&, int p) {
    return abs(rest.inverse_determinant[p]) * T(512.);
  }
  template <class T>
  static Gradients<T> gradients(const PointRest<T>& rest, const Tangent<T>&, int p) {
    return rest.g[p];
  }
  /// w^1/2 F at Gauss point p from J at the points.
  template <class T>
  static M3<T> deformation(const PointRest<T>& rest, const Tangent<T>&, const PointValues<T>& j, int p) {
    return outerSum(Columns<T>(j, p).d, rest.g[p]);
  }
  /// Adds the forces of the first Piola-Kirchhoff stress (times w^1/2) at Gauss point p, still as values at points.
  template <class T>
  static void addForces(const PointRest<T>& rest, const Tangent<T>&, const M3<T>& stress, int p, PointValues<T>& f) {
    const Gradients<T>& g = rest.g[p];
    addColumns(stress * g.g1, stress * g.g2, stress * g.g3, p, f);
  }
};

/// Gauss points of a box, in its own axes.
struct BoxShape : GaussShape {
  template <class T>
  using Rest = BoxRest<T>;
  template <class T>
  struct Tangent {
    T gradient[3];     ///< w^1/2 / 8 times 2 / edge length
    T inverse_weight;  ///< 1/w
    T lambda, mu;      ///< Lame's constants, or -2/3 mu and mu [Pa]
    T bulk;            ///< K/V, or zero without the mean dilatation [Pa/m^3]
  };
  template <class T>
  static T inverseWeight(const BoxRest<T>&, const Tangent<T>& t, int) {
    return t.inverse_weight;
  }
  template <class T>
  static Gradients<T> gradients(const BoxRest<T>&, const Tangent<T>& t, int) {
    const T zero(0.);
    return {{t.gradient[0], zero, zero}, {zero, t.gradient[1], zero}, {zero, zero, t.gradient[2]}};
  }
  template <class T>
  static M3<T> deformation(const BoxRest<T>&, const Tangent<T>& t, const PointValues<T>& j, int p) {
    const Columns<T> c(j, p);
    return {c.d[0] * t.gradient[0], c.d[1] * t.gradient[1], c.d[2] * t.gradient[2]};
  }
  template <class T>
  static void addForces(const BoxRest<T>&, const Tangent<T>& t, const M3<T>& stress, int p, PointValues<T>& f) {
    addColumns(stress.c0 * t.gradient[0], stress.c1 * t.gradient[1], stress.c2 * t.gradient[2], p, f);
  }
};

}  // namespace stroma::hexahedron
