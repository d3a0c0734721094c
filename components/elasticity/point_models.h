// SPDX-License-Identifier: LGPL-2.1-or-later
// Cells with several points: models for ModelKernels (model_kernels.h) of any shape, with a rotation taken out at each point.
// With G_i the gradients of xi, eta, zeta at rest and w a point's volume,
//   F = sum_i dx/dxi_i (x) G_i,   R the rotation of F at the point,   g_i = w^1/2 R G_i
//   w^1/2 eps = sym(sum_i dx/dxi_i (x) g_i) - w^1/2 I,   f on dx/dxi_i = -w^1/2 sigma g_i
//   sigma = lambda tr(eps) I + 2 mu eps + b (sum_q w_q tr(eps_q)) I
// b is zero for a volume change at each point; for one per element (mean dilatation) b = K/V, lambda = -2/3 mu. Small: R = I.
//
// A shape S has
//   nodes, points, PointValues<T>     derivatives along xi, eta, zeta at the points, or forces on them: d[points][3]
//   atPoints(x), nodesOf(values, f)   from positions to derivatives, and the transpose
//   nodeGradient(g, a, p)             the gradient of N_a at point p from those of xi, eta and zeta
#pragma once
#include "components/elasticity/element_matrix.h"
#include "components/elasticity/green_model.h"
#include "components/elasticity/rotation_methods.h"
#include "framework/fem/model_kernels.h"

namespace stroma::elastic {

template <class T>
Gradients<T> scaledBy(const Gradients<T>& g, T s) {
  return {g.g1 * s, g.g2 * s, g.g3 * s};
}
template <class T>
T trace(const S3<T>& s) {
  return s.xx + (s.yy + s.zz);
}

template <class S>
struct PointModels {
  static constexpr int nodes = S::nodes, points = S::points;
  template <class T>
  using PointValues = typename S::template PointValues<T>;

  /// G_i [1/m] of each point.
  template <class T>
  struct RestGradients {
    Gradients<T> g[points];
  };
  /// What a product reads: g_i at the last force (of the rest shape before the first) and the law.
  template <class T>
  struct PointTangent {
    Gradients<T> g[points];
    T root[points];  ///< w^1/2 [m^3/2]
    T lambda, mu;    ///< [Pa]
    T bulk;          ///< b [Pa/m^3]
  };
  /// All n_a of the points.
  template <class T>
  static void nodeGradients(const Gradients<T> (&g)[points], NodeGradients<nodes, points, T>& n) {
    for (int p = 0; p < points; ++p)
      for (int a = 0; a < nodes; ++a) n[a][p] = S::nodeGradient(g[p], a, p);
  }
  /// K of small strains. Not inlined, nor the others, for the compiler's sake.
  template <class T>
  [[gnu::noipa, gnu::flatten]] static void stiffnessMatrix(const auto& t, T (&k)[nodes * nodes * 9]) {
    NodeGradients<nodes, points, T> n;
    nodeGradients(t.g, n);
    smallStrainMatrix(n, t.lambda, t.mu, k);
    V3<T> mean[nodes];
    for (int a = 0; a < nodes; ++a)
      for (int p = 0; p < points; ++p) mean[a] = fma(t.root[p], n[a][p], mean[a]);
    addSquare(mean, t.bulk, k);
  }
  template <class T>
  [[gnu::noipa, gnu::flatten]] static void greenMatrix(const Gradients<T> (&g)[points], const GreenState<T> (&state)[points],
                                                T lambda, T mu, T (&k)[nodes * nodes * 9]) {
    NodeGradients<nodes, points, T> n;
    nodeGradients(g, n);
    greenStrainMatrix(n, state, lambda, mu, k);
  }
  template <class T>
  [[gnu::noipa, gnu::flatten]] static void addMeanMatrix(const Gradients<T> (&g)[points], const GreenState<T> (&state)[points],
                                                  T bulk, T (&k)[nodes * nodes * 9]) {
    V3<T> n[nodes];
    for (int a = 0; a < nodes; ++a)
      for (int p = 0; p < points; ++p) n[a] = n[a] + state[p].f * S::nodeGradient(g[p], a, p);
    addSquare(n, bulk, k);
  }

  /// w^1/2 sym(sum d_i (x) g_i) of each point.
  template <class T>
  static void strainsOf(const PointValues<T>& d, const Gradients<T> (&g)[points], S3<T> (&strain)[points]) {
    for (int p = 0; p < points; ++p) strain[p] = strainOf(d.d[p], g[p]);
  }
  /// -b sum w tr(eps)
  template <class T>
  static T meanPressure(const auto& t, const S3<T> (&strain)[points]) {
    T sum(0.);
    for (int p = 0; p < points; ++p) sum = fma(t.root[p], trace(strain[p]), sum);
    return -t.bulk * sum;
  }
  /// -factor w^1/2 sigma of point p.
  template <class T>
  static S3<T> stressAt(const auto& t, int p, const S3<T>& strain, T factor, T pressure) {
    S3<T> s = restoringStress(strain, factor * t.lambda, factor * t.mu);
    const T all = factor * pressure * t.root[p];
    s.xx += all, s.yy += all, s.zz += all;
    return s;
  }
  template <class T>
  static void addStress(const S3<T>& s, const Gradients<T>& g, int p, PointValues<T>& f) {
    V3<T>(&d)[3] = f.d[p];
    d[0] = d[0] + s * g.g1, d[1] = d[1] + s * g.g2, d[2] = d[2] + s * g.g3;
  }
  /// Forces of strains (times w^1/2) on the nodes.
  template <class T>
  static void forcesOf(const auto& t, const S3<T> (&strain)[points], T factor, V3<T> (&f)[nodes]) {
    const T pressure = meanPressure(t, strain);
    PointValues<T> forces;
    for (int p = 0; p < points; ++p) addStress(stressAt(t, p, strain[p], factor, pressure), t.g[p], p, forces);
    S::nodesOf(forces, f);
  }

  struct Model {
    static constexpr int nodes = S::nodes;
    static constexpr bool reads_position = false;
    using Products = Model;
    template <class T>
    using Rest = RestGradients<T>;
    template <class T>
    using Tangent = PointTangent<T>;

    template <class T>
    static void product(const auto&, const Tangent<T>& t, T factor, const V3<T> (&)[nodes], const V3<T> (&dx)[nodes],
                        V3<T> (&df)[nodes]) {
      S3<T> strain[points];
      strainsOf(S::atPoints(dx), t.g, strain);
      forcesOf(t, strain, factor, df);
    }
    template <class T>
    static void matrix(const auto&, const Tangent<T>& t, const V3<T> (&)[nodes], T (&k)[nodes * nodes * 9]) {
      stiffnessMatrix(t, k);
    }

   protected:
    /// Of the gradients of the tangent, at positions d.
    template <class T>
    static void strains(const auto& t, const PointValues<T>& d, S3<T> (&strain)[points]) {
      strainsOf(d, t.g, strain);
      for (int p = 0; p < points; ++p) strain[p].xx -= t.root[p], strain[p].yy -= t.root[p], strain[p].zz -= t.root[p];
    }
    template <class T>
    static T energyOf(const auto& t, const S3<T> (&strain)[points]) {
      T sum(0.), change(0.);
      for (int p = 0; p < points; ++p) {
        sum += storedEnergy(strain[p], t.lambda, t.mu);
        change = fma(t.root[p], trace(strain[p]), change);
      }
      return fma(T(0.5) * t.bulk * change, change, sum);
    }
  };

  /// method = small.
  struct Linear : Model {
    template <class T>
    static void force(const RestGradients<T>&, PointTangent<T>& t, const V3<T> (&x)[nodes], V3<T> (&f)[nodes]) {
      S3<T> strain[points];
      Model::strains(t, S::atPoints(x), strain);
      forcesOf(t, strain, T(1.), f);
    }
    template <class T>
    static T energy(const RestGradients<T>&, const PointTangent<T>& t, const V3<T> (&x)[nodes]) {
      S3<T> strain[points];
      Model::strains(t, S::atPoints(x), strain);
      return Model::energyOf(t, strain);
    }
  };

  /// method = large, polar, svd with the warped tangent.
  template <class Rotation>
  struct Corotational : Model {
    template <class T>
    static void force(const RestGradients<T>& rest, auto& t, const V3<T> (&x)[nodes], V3<T> (&f)[nodes]) {
      const PointValues<T> d = S::atPoints(x);
      turn(rest, d, t);
      S3<T> strain[points];
      Model::strains(t, d, strain);
      forcesOf(t, strain, T(1.), f);
    }
    template <class T>
    static T energy(const RestGradients<T>& rest, auto t, const V3<T> (&x)[nodes]) {
      const PointValues<T> d = S::atPoints(x);
      turn(rest, d, t);
      S3<T> strain[points];
      Model::strains(t, d, strain);
      return Model::energyOf(t, strain);
    }

   private:
    /// R and g_i at the positions of d.
    template <class T>
    static void turn(const RestGradients<T>& rest, const PointValues<T>& d, auto& t) {
      for (int p = 0; p < points; ++p) {
        const M3<T> r = Rotation::of(outerSum(d.d[p], rest.g[p]));
        t.g[p] = scaledBy(elastic::rotated(r, rest.g[p]), t.root[p]);
        if constexpr (requires { t.rotation; }) t.rotation[p] = r;
      }
    }
  };

  /// polarOf = nodes, as in SOFA: one rotation for all points, that of sum x_a (x) M_a, M_a = X_a - C of the rest shape.
  template <class T>
  struct RestPlaces {
    Gradients<T> g[points];
    V3<T> place[S::nodes];
  };
  template <class Rotation>
  struct OneRotation : Model {
    using Products = OneRotation;
    template <class T>
    using Rest = RestPlaces<T>;
    template <class T>
    using Tangent = PointTangent<T>;
    template <class T>
    static void force(const Rest<T>& rest, Tangent<T>& t, const V3<T> (&x)[S::nodes], V3<T> (&f)[S::nodes]) {
      S3<T> strain[points];
      turn(rest, x, t);
      Model::strains(t, S::atPoints(x), strain);
      forcesOf(t, strain, T(1.), f);
    }
    template <class T>
    static T energy(const Rest<T>& rest, Tangent<T> t, const V3<T> (&x)[S::nodes]) {
      S3<T> strain[points];
      turn(rest, x, t);
      Model::strains(t, S::atPoints(x), strain);
      return Model::energyOf(t, strain);
    }

   private:
    template <class T>
    static void turn(const Rest<T>& rest, const V3<T> (&x)[S::nodes], Tangent<T>& t) {
      M3<T> sum;
      for (int a = 0; a < S::nodes; ++a) {
        const V3<T>& place = rest.place[a];
        sum = sum + M3<T>{x[a] * place.x, x[a] * place.y, x[a] * place.z};
      }
      const M3<T> r = Rotation::of(sum);
      for (int p = 0; p < points; ++p) t.g[p] = scaledBy(elastic::rotated(r, rest.g[p]), t.root[p]);
    }
  };

  /// For method = green.
  struct GreenShape {
    static constexpr int nodes = S::nodes, points = S::points;
    template <class T>
    using Rest = RestGradients<T>;
    template <class T>
    using Tangent = PointTangent<T>;
    template <class T>
    static PointValues<T> at(const V3<T> (&x)[nodes]) {
      return S::atPoints(x);
    }
    template <class T>
    static void toNodes(const PointValues<T>& forces, V3<T> (&f)[nodes]) {
      S::nodesOf(forces, f);
    }
    template <class T>
    static T inverseWeight(const Rest<T>&, const Tangent<T>& t, int p) {
      return T(1.) / (t.root[p] * t.root[p]);
    }
    /// With w^1/2; green turns nothing, so that those of the tangent stay.
    template <class T>
    static Gradients<T> gradients(const Rest<T>&, const Tangent<T>& t, int p) {
      return t.g[p];
    }
    template <class T>
    static M3<T> deformation(const Rest<T>&, const Tangent<T>& t, const PointValues<T>& j, int p) {
      return outerSum(j.d[p], t.g[p]);
    }
    template <class T>
    static void addForces(const Rest<T>&, const Tangent<T>& t, const M3<T>& stress, int p, PointValues<T>& f) {
      f.d[p][0] = stress * t.g[p].g1, f.d[p][1] = stress * t.g[p].g2, f.d[p][2] = stress * t.g[p].g3;
    }
    template <class T>
    static void matrixOf(const Gradients<T> (&g)[points], const GreenState<T> (&state)[points], T lambda, T mu,
                         T (&k)[nodes * nodes * 9]) {
      greenMatrix(g, state, lambda, mu, k);
    }
    template <class T>
    static void addMeanMatrixOf(const Gradients<T> (&g)[points], const GreenState<T> (&state)[points], T bulk,
                                T (&k)[nodes * nodes * 9]) {
      addMeanMatrix(g, state, bulk, k);
    }
  };
};

}  // namespace stroma::elastic
