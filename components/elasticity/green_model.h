// SPDX-License-Identifier: LGPL-2.1-or-later
// method = green: St. Venant-Kirchhoff, no rotation, at the points of any element. A shape has
//   nodes, points, Rest<T>, Tangent<T>   the tangent with lambda, mu and bulk
//   at(x), toNodes(values, f)            differences at the points, and forces on them back to nodes
//   deformation(), gradients(), inverseWeight(), addForces()   of a point, with w^1/2 in F and the gradients
//   matrixOf(), addMeanMatrixOf()        K of the points, and its part of a mean dilatation, out of line
#pragma once
#include "components/elasticity/element_matrix.h"
#include "components/elasticity/strain.h"

namespace stroma::elastic {

/// `mean`: the volume change is the mean of tr(E) over the element; its stress is F times one pressure.
template <class Shape, bool mean>
struct GreenModel {
  static constexpr int nodes = Shape::nodes, points = Shape::points;
  static constexpr bool reads_position = true;
  template <class T>
  using Rest = typename Shape::template Rest<T>;
  template <class T>
  using Tangent = typename Shape::template Tangent<T>;

  template <class T>
  static void force(const auto& rest, const auto& t, const V3<T> (&x)[nodes], V3<T> (&f)[nodes]) {
    const auto j = Shape::at(x);
    const T pressure = pressureOf<T>(rest, t, j);
    std::decay_t<decltype(j)> forces;
    for (int p = 0; p < points; ++p) {
      const M3<T> deformation = Shape::deformation(rest, t, j, p);
      M3<T> stress = greenStress(deformation, Shape::inverseWeight(rest, t, p), t.lambda, t.mu);
      if constexpr (mean) stress = stress + deformation * pressure;
      Shape::addForces(rest, t, stress, p, forces);
    }
    Shape::toNodes(forces, f);
  }
  template <class T>
  static T energy(const auto& rest, const auto& t, const V3<T> (&x)[nodes]) {
    const auto j = Shape::at(x);
    T sum(0.), volume_change(0.);
    for (int p = 0; p < points; ++p) {
      const T inverse_weight = Shape::inverseWeight(rest, t, p);
      const S3<T> strain = greenStrain(Shape::deformation(rest, t, j, p), inverse_weight);
      sum += storedEnergy(strain, t.lambda, t.mu) / inverse_weight;
      volume_change += (strain.xx + strain.yy + strain.zz) / inverse_weight;
    }
    if constexpr (mean) sum += T(0.5) * t.bulk * volume_change * volume_change;
    return sum;
  }
  template <class T>
  static void product(const auto& rest, const auto& t, T factor, const V3<T> (&x)[nodes], const V3<T> (&dx)[nodes],
                      V3<T> (&df)[nodes]) {
    const auto j = Shape::at(x), dj = Shape::at(dx);
    const T lambda = factor * t.lambda, mu = factor * t.mu;
    const T pressure = factor * pressureOf<T>(rest, t, j), dpressure = factor * pressureDifferential<T>(rest, t, j, dj);
    std::decay_t<decltype(j)> forces;
    for (int p = 0; p < points; ++p) {
      const M3<T> f = Shape::deformation(rest, t, j, p), change = Shape::deformation(rest, t, dj, p);
      M3<T> stress = greenStressDifferential(f, change, Shape::inverseWeight(rest, t, p), lambda, mu);
      if constexpr (mean) stress = stress + change * pressure + f * dpressure;
      Shape::addForces(rest, t, stress, p, forces);
    }
    Shape::toNodes(forces, df);
  }
  template <class T>
  static void matrix(const auto& rest, const auto& t, const V3<T> (&x)[nodes], T (&k)[nodes * nodes * 9]) {
    const auto j = Shape::at(x);
    const T pressure = pressureOf<T>(rest, t, j);
    Gradients<T> g[points];
    GreenState<T> state[points];
    for (int p = 0; p < points; ++p) {
      g[p] = Shape::gradients(rest, t, p);
      state[p].f = Shape::deformation(rest, t, j, p);
      state[p].inverse_weight = Shape::inverseWeight(rest, t, p);
      S3<T>& s = state[p].minus_s;
      s = restoringStress(greenStrain(state[p].f, state[p].inverse_weight), t.lambda, t.mu);
      if constexpr (mean) s.xx += pressure, s.yy += pressure, s.zz += pressure;
    }
    Shape::matrixOf(g, state, t.lambda, t.mu, k);
    if constexpr (mean) Shape::addMeanMatrixOf(g, state, t.bulk, k);
  }

 private:
  /// -K/V sum w tr(E)
  template <class T>
  static T pressureOf(const auto& rest, const auto& t, const auto& j) {
    if constexpr (!mean) return T(0.);
    T sum(0.);  // tr(F^T F) holds the weight already
    for (int p = 0; p < points; ++p) {
      const M3<T> f = Shape::deformation(rest, t, j, p);
      sum += T(0.5) * squaredNorm(f) - T(1.5) / Shape::inverseWeight(rest, t, p);
    }
    return -t.bulk * sum;
  }
  template <class T>
  static T pressureDifferential(const auto& rest, const auto& t, const auto& j, const auto& dj) {
    if constexpr (!mean) return T(0.);
    T sum(0.);
    for (int p = 0; p < points; ++p) {
      const M3<T> f = Shape::deformation(rest, t, j, p), change = Shape::deformation(rest, t, dj, p);
      sum += stroma::dot(f.c0, change.c0) + (stroma::dot(f.c1, change.c1) + stroma::dot(f.c2, change.c2));
    }
    return -t.bulk * sum;
  }
};

}  // namespace stroma::elastic
