// SPDX-License-Identifier: LGPL-2.1-or-later
// Laws in principal stretches: sums of f_k(J) g_k(C) with g_k = sum_i phi_k(c_i) over the eigenvalues c_i of C = sum
// c_i n_i (x) n_i, and a function U(J). In the frame of the n_i, dC rotated there,
//   S_ii = 2 sum_k f_k phi_k'(c_i)
//   dS_ii = 2 sum_k (f_k phi_k'' dC_ii + f_k' phi_k' dJ),   dS_ij = 2 sum_k f_k (phi_k'(c_i) - phi_k'(c_j))/(c_i - c_j)
//   dC_ij dpsi_J = sum_k f_k' sum_i phi_k'(c_i) dC_ii + psi_JJ dJ
// which holds for every dC, also where it has other axes than C, and where eigenvalues meet.
//
// A law of this kind has Set = PrincipalStretches and, with p its parameters,
//   volumetric(J, p)                  U, an expression like `energy`
//   addEnergy(point, p, sum)          sum += sum_k f_k g_k
//   addDerivatives(point, p, w)       the same to SpectralDerivatives, without a weight
#pragma once
#include "components/hyperelasticity/hyperelastic_point.h"

namespace stroma::hyperelastic {

/// sinh(y)/y, by its series or from the exponential.
template <class T>
T sinhOverArgument(T y) {
  const T square = y * y;
  T series(1.);
  for (int n = 8; n >= 1; --n) series = fma(series, square * T(1. / (2 * n * (2 * n + 1))), T(1.));
  const auto small = square < T(1.);
  const T safe = select(small, T(1.), y), up = exp(safe);
  return select(small, series, T(0.5) * (up - T(1.) / up) / safe);
}

/// (a^beta - b^beta)/(a - b) from the logarithms of a and b; beta a^(beta - 1) where they meet.
template <class T>
struct DividedDifference {
  T mean, delta, scale;
  DividedDifference(T log_a, T log_b)
      : mean(T(0.5) * (log_a + log_b)), delta(T(0.5) * (log_a - log_b)), scale(T(1.) / sinhOverArgument(delta)) {}
  T of(T beta) const { return exp((beta - T(1.)) * mean) * beta * sinhOverArgument(beta * delta) * scale; }
};

struct PrincipalStretches {
  static constexpr bool anisotropic = false;
  /// F in the frame of the principal directions (columns of `axes`).
  template <class T>
  struct Point : VolumePoint<T> {
    M3<T> axes;
    T log_j, log_c[3];
    template <class Parameters>
    Point(const M3<T>& deformation, const Parameters&) : VolumePoint<T>(deformation) {
      const S3<T> c = metric(deformation);
      T a[3][3] = {{c.xx, c.xy, c.zx}, {c.xy, c.yy, c.yz}, {c.zx, c.yz, c.zz}}, v[3][3];
      diagonalise(a, v);
      for (int i = 0; i < 3; ++i) log_c[i] = log(a[i][i]);
      log_j = log(this->j);
      axes = {{v[0][0], v[1][0], v[2][0]}, {v[0][1], v[1][1], v[2][1]}, {v[0][2], v[1][2], v[2][2]}};
    }
  };
};
template <class Law>
concept InPrincipalStretches = std::same_as<typename Law::Set, PrincipalStretches>;

/// What the derivatives are made of, times a weight.
template <class T>
struct SpectralDerivatives {
  M3<T> axes;
  T s[3];             ///< S_ii
  T normal[3];        ///< 2 sum f phi''
  T shear[3];         ///< 2 sum f (phi' - phi')/(c - c) of 12, 23, 31
  T coupling[3];      ///< 2 sum f' phi'
  T volume, volume2;  ///< psi_J, psi_JJ
};

template <InPrincipalStretches Law, class T>
[[gnu::noipa]] T spectralEnergy(const PrincipalStretches::Point<T>& p, const auto& parameters) {
  T sum = Law::volumetric(p.j, parameters);
  Law::addEnergy(p, parameters, sum);
  return sum;
}

template <InPrincipalStretches Law, class T>
[[gnu::noipa]] SpectralDerivatives<T> spectralDerivatives(const PrincipalStretches::Point<T>& p, const auto& parameters,
                                                          T weight) {
  SpectralDerivatives<T> w{};
  const auto u = Law::volumetric(variable<0>(p.j), parameters);
  w.axes = p.axes, w.volume = u.a, w.volume2 = u.aa;
  Law::addDerivatives(p, parameters, w);
  for (int i = 0; i < 3; ++i)
    w.s[i] = w.s[i] * weight, w.normal[i] = w.normal[i] * weight, w.shear[i] = w.shear[i] * weight,
    w.coupling[i] = w.coupling[i] * weight;
  w.volume = w.volume * weight, w.volume2 = w.volume2 * weight;
  return w;
}

/// dS for dC and dJ, both in the principal frame.
template <class T>
S3<T> spectralStressDifferential(const SpectralDerivatives<T>& w, const S3<T>& dc, T dj) {
  return {fma(w.normal[0], dc.xx, w.coupling[0] * dj),
          fma(w.normal[1], dc.yy, w.coupling[1] * dj),
          fma(w.normal[2], dc.zz, w.coupling[2] * dj),
          w.shear[0] * dc.xy,
          w.shear[1] * dc.yz,
          w.shear[2] * dc.zx};
}
/// A S A^T, S in the frame A.
template <class T>
S3<T> turned(const M3<T>& axes, const S3<T>& s) {
  const M3<T> back = transpose(axes), half = timesSymmetric(axes, s);  // half back
  const V3<T> x = half * back.c0, y = half * back.c1, z = half * back.c2;
  return {x.x, y.y, z.z, y.x, z.y, x.z};
}

template <InPrincipalStretches Law_>
struct Mjed<Law_> {
  using Law = Law_;
  template <class T>
  using Parameters = typename Law::template Parameters<T>;
  template <class T>
  using Point = PrincipalStretches::Point<T>;
  template <class T>
  struct Tangent {
    SpectralDerivatives<T> w;
  };

  template <class T>
  static M3<T> stress(const Parameters<T>& parameters, T weight, const M3<T>& f, Tangent<T>& t) {
    const Point<T> p(f, parameters);
    t.w = spectralDerivatives<Law>(p, parameters, weight);
    const S3<T> s = turned(p.axes, S3<T>{t.w.s[0], t.w.s[1], t.w.s[2], T(0.), T(0.), T(0.)});
    return timesSymmetric(f, s) + p.cof * t.w.volume;
  }
  /// The principal part of the tangent; `of_unit` is taken out of psi_JJ.
  template <class T>
  static M3<T> differential(const Tangent<T>& t, const M3<T>& f, const M3<T>& df, T of_unit) {
    const VolumePoint<T> p(f);
    const SpectralDerivatives<T>& w = t.w;
    const M3<T> own = f * w.axes, change = df * w.axes;  // columns along the principal directions
    const S3<T> dc = metricDifferential(own, change);
    const T dj = dot(p.cof, df);
    const T dvolume = fma(w.volume2 - of_unit, dj,
                          T(0.5) * fma(w.coupling[0], dc.xx, fma(w.coupling[1], dc.yy, w.coupling[2] * dc.zz)));
    const M3<T> stretched{change.c0 * w.s[0], change.c1 * w.s[1], change.c2 * w.s[2]};
    const M3<T> in_frame = stretched + timesSymmetric(own, spectralStressDifferential(w, dc, dj));
    return (in_frame * transpose(w.axes) + cofactorDifferential(f, df) * w.volume) + p.cof * dvolume;
  }
  template <class T>
  static M3<T> differential(const Parameters<T>&, T, const Tangent<T>& t, const M3<T>& f, const M3<T>& df) {
    return differential(t, f, df, T(0.));
  }
  template <class T>
  static T energy(const Parameters<T>& parameters, const M3<T>& f) {
    return spectralEnergy<Law>(Point<T>(f, parameters), parameters);
  }
  template <class T>
  static void secondStress(const Parameters<T>& parameters, const M3<T>& f, S3<T>& s, Elasticity<T>& d) {
    const Point<T> p(f, parameters);
    const SpectralDerivatives<T> w = spectralDerivatives<Law>(p, parameters, T(1.));
    s = turned(p.axes, S3<T>{w.s[0], w.s[1], w.s[2], T(0.), T(0.), T(0.)});
    const S3<T> coupling = turned(p.axes, S3<T>{w.coupling[0], w.coupling[1], w.coupling[2], T(0.), T(0.), T(0.)});
    for (int k = 0; k < 6; ++k) {  // dS of a unit strain with doubled shear
      const T one(k < 3 ? 2. : 1.);
      S3<T> dc;
      T* const entry[6] = {&dc.xx, &dc.yy, &dc.zz, &dc.xy, &dc.yz, &dc.zx};
      *entry[k] = one;
      T column[6];
      list(turned(p.axes, spectralStressDifferential(w, turned(transpose(p.axes), dc), T(0.))), column);
      for (int i = 0; i < 6; ++i) d.d[i][k] = column[i];
    }
    addVolumetric(p, w.volume, w.volume2, s, d);
    addOuter(T(2.) * p.j, inverse(metric(f)), coupling, d);
  }
};

template <InPrincipalStretches Law_>
struct Regularised<Law_> : Mjed<Law_> {
  using Base = Mjed<Law_>;
  template <class T>
  static M3<T> differential(const ParametersOf<Law_, T>&, T, const typename Base::template Tangent<T>& t,
                            const M3<T>& f, const M3<T>& df) {
    const VolumePoint<T> p(f);
    const T of_unit = regularisation(p.j) * t.w.volume2;
    return Base::differential(t, f, df, of_unit) + timesSymmetric(df, metric(p.cof) * of_unit);
  }
};

}  // namespace stroma::hyperelastic
