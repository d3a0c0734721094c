// SPDX-License-Identifier: LGPL-2.1-or-later
// method = green of hexahedra: St. Venant-Kirchhoff, no rotation. Gradients hold w^1/2 / 8, so that F is w^1/2 F.
#pragma once
#include "components/elasticity/hexahedron_matrix.h"
#include "components/elasticity/hexahedron_rest.h"

namespace stroma::hexahedron {

/// Gauss points of any shape.
struct PointShape {
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
struct BoxShape {
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

/// `mean`: the volume change is the mean of tr(E) over the element; its stress is F times one pressure.
template <class Shape, bool mean>
struct Green : HexahedronModel {
  static constexpr bool reads_position = true;
  template <class T>
  using Rest = typename Shape::template Rest<T>;
  template <class T>
  using Tangent = typename Shape::template Tangent<T>;

  template <class T>
  static void force(const auto& rest, const auto& t, const V3<T> (&x)[8], V3<T> (&f)[8]) {
    const PointValues<T> j = atPoints(modesOf(x));
    const T pressure = pressureOf(rest, t, j);
    PointValues<T> forces;
    for (int p = 0; p < 8; ++p) {
      const M3<T> deformation = Shape::deformation(rest, t, j, p);
      M3<T> stress = greenStress(deformation, Shape::inverseWeight(rest, t, p), t.lambda, t.mu);
      if constexpr (mean) stress = stress + deformation * pressure;
      Shape::addForces(rest, t, stress, p, forces);
    }
    nodesOf(fromPoints(forces), f);
  }
  template <class T>
  static T energy(const auto& rest, const auto& t, const V3<T> (&x)[8]) {
    const PointValues<T> j = atPoints(modesOf(x));
    T sum(0.), volume_change(0.);
    for (int p = 0; p < 8; ++p) {
      const T inverse_weight = Shape::inverseWeight(rest, t, p);
      const S3<T> strain = greenStrain(Shape::deformation(rest, t, j, p), inverse_weight);
      sum += storedEnergy(strain, t.lambda, t.mu) / inverse_weight;
      volume_change += (strain.xx + strain.yy + strain.zz) / inverse_weight;
    }
    if constexpr (mean) sum += T(0.5) * t.bulk * volume_change * volume_change;
    return sum;
  }
  template <class T>
  static void product(const auto& rest, const auto& t, T factor, const V3<T> (&x)[8], const V3<T> (&dx)[8],
                      V3<T> (&df)[8]) {
    const PointValues<T> j = atPoints(modesOf(x)), dj = atPoints(modesOf(dx));
    const T lambda = factor * t.lambda, mu = factor * t.mu;
    const T pressure = factor * pressureOf(rest, t, j), dpressure = factor * pressureDifferential(rest, t, j, dj);
    PointValues<T> forces;
    for (int p = 0; p < 8; ++p) {
      const M3<T> f = Shape::deformation(rest, t, j, p), change = Shape::deformation(rest, t, dj, p);
      M3<T> stress = greenStressDifferential(f, change, Shape::inverseWeight(rest, t, p), lambda, mu);
      if constexpr (mean) stress = stress + change * pressure + f * dpressure;
      Shape::addForces(rest, t, stress, p, forces);
    }
    nodesOf(fromPoints(forces), df);
  }
  template <class T>
  static void matrix(const auto& rest, const auto& t, const V3<T> (&x)[8], T (&k)[8 * 8 * 9]) {
    const PointValues<T> j = atPoints(modesOf(x));
    const T pressure = pressureOf(rest, t, j);
    Gradients<T> g[8];
    GreenState<T> state[8];
    for (int p = 0; p < 8; ++p) {
      g[p] = Shape::gradients(rest, t, p);
      state[p].f = Shape::deformation(rest, t, j, p);
      state[p].inverse_weight = Shape::inverseWeight(rest, t, p);
      S3<T>& s = state[p].minus_s;
      s = restoringStress(greenStrain(state[p].f, state[p].inverse_weight), t.lambda, t.mu);
      if constexpr (mean) s.xx += pressure, s.yy += pressure, s.zz += pressure;
    }
    greenMatrix(g, state, t.lambda, t.mu, k);
    if constexpr (mean) addMeanMatrix(g, state, t.bulk, k);
  }

 private:
  /// -K/V sum w tr(E)
  template <class T>
  static T pressureOf(const auto& rest, const auto& t, const PointValues<T>& j) {
    if constexpr (!mean) return T(0.);
    T sum(0.);  // tr(F^T F) holds the weight already
    for (int p = 0; p < 8; ++p) {
      const M3<T> f = Shape::deformation(rest, t, j, p);
      sum += T(0.5) * squaredNorm(f) - T(1.5) / Shape::inverseWeight(rest, t, p);
    }
    return -t.bulk * sum;
  }
  template <class T>
  static T pressureDifferential(const auto& rest, const auto& t, const PointValues<T>& j, const PointValues<T>& dj) {
    if constexpr (!mean) return T(0.);
    T sum(0.);
    for (int p = 0; p < 8; ++p) {
      const M3<T> f = Shape::deformation(rest, t, j, p), change = Shape::deformation(rest, t, dj, p);
      sum += stroma::dot(f.c0, change.c0) + (stroma::dot(f.c1, change.c1) + stroma::dot(f.c2, change.c2));
    }
    return -t.bulk * sum;
  }
};

}  // namespace stroma::hexahedron
