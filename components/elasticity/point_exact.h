// SPDX-License-Identifier: LGPL-2.1-or-later
// Cells with several points (point_models.h), with rotations and the exact tangent.
#pragma once
#include "components/elasticity/point_models.h"

namespace stroma::elastic {

/// The exact tangent reads R too.
template <int points, class T>
struct ExactTangent {
  Gradients<T> g[points];
  T root[points], lambda, mu, bulk;
  M3<T> rotation[points];
};

/// method = large, polar, svd: R is differentiated at the x of the last force.
template <class S, class Rotation>
struct ExactCorotational : PointModels<S>::template Corotational<Rotation> {
  using Models = PointModels<S>;
  using Products = ExactCorotational;
  static constexpr bool reads_position = true;
  static constexpr int nodes = S::nodes, points = S::points;
  template <class T>
  using PointValues = typename S::template PointValues<T>;
  template <class T>
  using Rest = typename Models::template RestGradients<T>;
  template <class T>
  using Tangent = ExactTangent<points, T>;

  template <class T>
  static void product(const Rest<T>& rest, const Tangent<T>& t, T factor, const V3<T> (&x)[nodes],
                      const V3<T> (&dx)[nodes], V3<T> (&df)[nodes]) {
    const PointValues<T> d = S::atPoints(x), dd = S::atPoints(dx);
    S3<T> strain[points], dstrain[points];
    Gradients<T> dg[points];
    Models::Model::strains(t, d, strain);
    for (int p = 0; p < points; ++p) {
      const M3<T> dr = Rotation::differential(outerSum(d.d[p], rest.g[p]), t.rotation[p], outerSum(dd.d[p], rest.g[p]));
      dg[p] = scaledBy(elastic::rotated(dr, rest.g[p]), t.root[p]);
      dstrain[p] = strainOf(dd.d[p], t.g[p]) + strainOf(d.d[p], dg[p]);
    }
    const T pressure = Models::meanPressure(t, strain), dpressure = Models::meanPressure(t, dstrain);
    PointValues<T> forces;
    for (int p = 0; p < points; ++p) {
      Models::addStress(Models::stressAt(t, p, dstrain[p], factor, dpressure), t.g[p], p, forces);
      Models::addStress(Models::stressAt(t, p, strain[p], factor, pressure), dg[p], p, forces);
    }
    S::nodesOf(forces, df);
  }
  /// What the warped tangent has, and what comes of the rotations at the points. It need not be symmetric.
  template <class T>
  static void matrix(const Rest<T>& rest, const Tangent<T>& t, const V3<T> (&x)[nodes], T (&k)[nodes * nodes * 9]) {
    Models::stiffnessMatrix(t, k);
    addTurningOf(rest, t, x, k);
  }

 private:
  template <class T>
  [[gnu::noipa, gnu::flatten]] static void addTurningOf(const Rest<T>& rest, const Tangent<T>& t, const V3<T> (&x)[nodes],
                                                        T (&k)[nodes * nodes * 9]) {
    const PointValues<T> d = S::atPoints(x);
    S3<T> strain[points];
    Models::Model::strains(t, d, strain);
    const T pressure = Models::meanPressure(t, strain);
    // the last: of the pressure of a mean dilatation, whose change turning may be too
    V3<T> forces[nodes][3 * points + 1], spins[nodes][3 * points + 1];
    for (int p = 0; p < points; ++p) {
      V3<T> along[3][3];  // [xi, eta, zeta][angle]
      const M3<T> f = outerSum(d.d[p], rest.g[p]);
      spinsAlong<Rotation>(f, t.rotation[p], rest.g[p].g1, along[0]);
      spinsAlong<Rotation>(f, t.rotation[p], rest.g[p].g2, along[1]);
      spinsAlong<Rotation>(f, t.rotation[p], rest.g[p].g3, along[2]);
      const S3<T> stress = Models::stressAt(t, p, strain[p], T(1.), pressure);
      for (int m = 0; m < 3; ++m) {
        const Gradients<T> dg = scaledBy(elastic::rotated(turnedAbout(t.rotation[p], m), rest.g[p]), t.root[p]);
        const S3<T> change = strainOf(d.d[p], dg), dstress = Models::stressAt(t, p, change, T(1.), T(0.));
        const Gradients<T> force{dstress * t.g[p].g1 + stress * dg.g1, dstress * t.g[p].g2 + stress * dg.g2,
                                 dstress * t.g[p].g3 + stress * dg.g3},
            spin{along[0][m], along[1][m], along[2][m]};
        const T growth = -t.bulk * t.root[p] * trace(change);
        for (int a = 0; a < nodes; ++a) {
          forces[a][3 * p + m] = S::nodeGradient(force, a, p), spins[a][3 * p + m] = S::nodeGradient(spin, a, p);
          spins[a][3 * points] = fma(growth, spins[a][3 * p + m], spins[a][3 * points]);
        }
      }
      for (int a = 0; a < nodes; ++a)
        forces[a][3 * points] = fma(t.root[p], S::nodeGradient(t.g[p], a, p), forces[a][3 * points]);
    }
    addTurning(forces, spins, k);
  }
};

}  // namespace stroma::elastic
