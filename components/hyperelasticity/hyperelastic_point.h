// SPDX-License-Identifier: LGPL-2.1-or-later
// A law at one integration point: P(F), its derivative, and the energy. Four forms of the same law:
//   Mjed         the energy's derivatives by J and invariants (hyperelastic_invariants.h), exact tangent
//   Regularised  the same with section 2.3 of Marchesseau et al. 2010: under compression the tangent's
//                psi_JJ dJ (x) dJ becomes psi_JJ ((1 - b) dJ_i (x) dJ_j + b (dJ_i . dJ_j) Id),
//                b = 1 - J on [0, 1], 0 above, 1 below; in terms of F: b dF cof^T cof. psi_JJ is the whole second
//                derivative by J, for exponentials also its parts with the square of the exponent's derivative. A law
//                whose psi_JJ is zero whatever F (StVenantKirchhoff) keeps its exact tangent: scenes refuse the pair
//   Projected    the exact 9 x 9 dP/dF with its unstable eigenvalues set to zero
//   Standard     the textbook's total Lagrangian form: S and D = 4 d2W/dC2 with C^-1, dP = dF S + F (D dE)
// Everything is scaled by a weight, minus the volume, so that P g_i are forces.
#pragma once
#include <cassert>
#include <cstring>

#include "components/hyperelasticity/hyperelastic_invariants.h"
#include "components/hyperelasticity/hyperelastic_law.h"
#include "components/hyperelasticity/symmetric_projection.h"

namespace stroma::hyperelastic {

/// A law's Parameters from those of a scene: the same numbers, unless the law reads them itself.
template <class Law>
typename Law::template Parameters<double> parametersOf(Values values) {
  if constexpr (requires { Law::read(values); }) {
    return Law::read(values);
  } else {
    typename Law::template Parameters<double> parameters;
    static_assert(sizeof parameters % sizeof(double) == 0);
    assert(values.size_bytes() == sizeof parameters);
    std::memcpy(&parameters, values.data(), sizeof parameters);
    return parameters;
  }
}

/// The derivatives of a law's energy at a point, as a jet.
template <class Law, class T>
using Derivatives =
    decltype(jetOfEnergy<Law>(std::declval<const typename Law::Set::template Point<T>&>(),
                              std::declval<const typename Law::template Parameters<T>&>()));
template <class Law>
constexpr int derivative_count = derivativeCount(static_cast<const Derivatives<Law, double>*>(nullptr));

/// C^-1.
template <class T>
S3<T> inverse(const S3<T>& c) {
  const T xx = fma(c.yy, c.zz, -c.yz * c.yz), xy = fma(c.zx, c.yz, -c.xy * c.zz), zx = fma(c.xy, c.yz, -c.zx * c.yy);
  const T scale = T(1.) / fma(c.xx, xx, fma(c.xy, xy, c.zx * zx));
  return S3<T>{xx, fma(c.xx, c.zz, -c.zx * c.zx), fma(c.xx, c.yy, -c.xy * c.xy),
               xy, fma(c.xy, c.zx, -c.xx * c.yz), zx} *
         scale;
}
/// S and D of a function of J with first and second derivative a and aa: dJ/dC = J C^-1 / 2, d2J/dC2 =
/// J (C^-1 (x) C^-1 / 4 - C^-1 o C^-1 / 2).
template <class T>
void addVolumetric(const VolumePoint<T>& p, const T& a, const auto& aa, S3<T>& s, Elasticity<T>& d) {
  const S3<T> ci = inverse(metric(p.f));
  const T ja = p.j * a;
  s = s + ci * ja;
  addOuter(T(ja + p.j * p.j * aa), ci, ci, d);
  const T m[3][3] = {{ci.xx, ci.xy, ci.zx}, {ci.xy, ci.yy, ci.yz}, {ci.zx, ci.yz, ci.zz}};
  constexpr int row[6] = {0, 1, 2, 0, 1, 2}, column[6] = {0, 1, 2, 1, 2, 0};
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j)
      d.d[i][j] -= ja * fma(m[row[i]][row[j]], m[column[i]][column[j]], m[row[i]][column[j]] * m[column[i]][row[j]]);
}

template <class Law, class T>
using ParametersOf = typename Law::template Parameters<T>;

template <class Law_>
struct Mjed {
  using Law = Law_;
  using Set = typename Law::Set;
  template <class T>
  using Parameters = typename Law::template Parameters<T>;
  template <class T>
  using Point = typename Set::template Point<T>;

  template <class T>
  struct Tangent {
    T derivatives[derivative_count<Law>];  ///< of the energy, times the weight
  };
  template <class T>
  static void keep(Derivatives<Law, T> w, T weight, Tangent<T>& t) {
    int k = 0;
    forEachDerivative(w, [&](T& d) { t.derivatives[k++] = weight * d; });
  }
  template <class T>
  static Derivatives<Law, T> kept(const Tangent<T>& t) {
    Derivatives<Law, T> w;
    int k = 0;
    forEachDerivative(w, [&](T& d) { d = t.derivatives[k++]; });
    return w;
  }

  template <class T>
  static M3<T> stress(const Parameters<T>& parameters, T weight, const M3<T>& f, Tangent<T>& t) {
    const Point<T> p(f, parameters);
    keep(jetOfEnergy<Law>(p, parameters), weight, t);
    return Set::stress(p, kept(t));
  }
  template <class T>
  static M3<T> differential(const Parameters<T>& parameters, T /*weight*/, const Tangent<T>& t, const M3<T>& f,
                            const M3<T>& df) {
    const Point<T> p(f, parameters);
    return Set::differential(p, kept(t), df);
  }
  template <class T>
  static T energy(const Parameters<T>& parameters, const M3<T>& f) {
    return energyAt<Law>(Point<T>(f, parameters), parameters);
  }
  /// S and D; d comes as zero.
  template <class T>
  static void secondStress(const Parameters<T>& parameters, const M3<T>& f, S3<T>& s, Elasticity<T>& d) {
    const Point<T> p(f, parameters);
    const auto w = jetOfEnergy<Law>(p, parameters);
    S3<T> a[3];
    Set::gradients(p, a);
    Set::curvature(p, w, d);
    s = S3<T>{} + scaled(2. * w.b, a[0]) + scaled(2. * w.c, a[1]) + scaled(2. * w.d, a[2]);
    addOuterUnlessZero(4. * w.bb, a[0], a[0], d);
    addOuterUnlessZero(8. * w.bc, a[0], a[1], d);
    addOuterUnlessZero(4. * w.cc, a[1], a[1], d);
    addOuterUnlessZero(8. * w.bd, a[0], a[2], d);
    addOuterUnlessZero(8. * w.cd, a[1], a[2], d);
    addOuterUnlessZero(4. * w.dd, a[2], a[2], d);
    if constexpr (NotZero<decltype(w.a)>) {
      addVolumetric(p, w.a, w.aa, s, d);
      const S3<T> ci = inverse(metric(p.f));
      addOuterUnlessZero(4. * (p.j * w.ab), ci, a[0], d);
      addOuterUnlessZero(4. * (p.j * w.ac), ci, a[1], d);
      addOuterUnlessZero(4. * (p.j * w.ad), ci, a[2], d);
    }
  }
};

/// The share b of the tangent's volumetric part that becomes a multiple of the identity.
template <class T>
T regularisation(T j) {
  return maximum(T(0.), T(1.) - maximum(T(0.), j));
}

template <class Law_>
struct Regularised : Mjed<Law_> {
  using Base = Mjed<Law_>;

  template <class T>
  static M3<T> differential(const ParametersOf<Law_, T>& parameters, T /*weight*/,
                            const typename Base::template Tangent<T>& t, const M3<T>& f, const M3<T>& df) {
    const typename Base::template Point<T> p(f, parameters);
    auto w = Base::kept(t);
    if constexpr (NotZero<decltype(w.aa)>) {
      const T of_unit = regularisation(p.j) * w.aa;
      w.aa = w.aa - of_unit;
      return Base::Set::differential(p, w, df) + timesSymmetric(df, metric(p.cof) * of_unit);
    } else {
      return Base::Set::differential(p, w, df);
    }
  }
};

/// The 9 numbers of a matrix, by columns.
template <class T>
void list(const M3<T>& m, T (&out)[9]) {
  const V3<T>* columns[3] = {&m.c0, &m.c1, &m.c2};
  for (int i = 0; i < 3; ++i)
    out[3 * i] = columns[i]->x, out[3 * i + 1] = columns[i]->y, out[3 * i + 2] = columns[i]->z;
}
template <class T>
M3<T> matrixOf(const T (&v)[9]) {
  return {{v[0], v[1], v[2]}, {v[3], v[4], v[5]}, {v[6], v[7], v[8]}};
}
/// Column k of the 9 x 9 tangent: the differential in the direction of number k of F.
template <class T, class Differential>
void columnOf(int k, Differential&& differential, T (&out)[9]) {
  T direction[9];
  for (int i = 0; i < 9; ++i) direction[i] = T(i == k ? 1. : 0.);
  list(differential(matrixOf(direction)), out);
}

/// out = A v, A symmetric by the rows of its lower triangle.
template <std::size_t numbers, std::size_t n, class T>
[[gnu::always_inline]] inline void multiplySymmetric(const T (&a)[numbers], const T (&v)[n], T (&out)[n]) {
  static_assert(numbers == n * (n + 1) / 2);
  for (T& sum : out) sum = T(0.);
  for (int i = 0, k = 0; i < int(n); ++i)
    for (int j = 0; j <= i; ++j, ++k) {
      out[i] = fma(a[k], v[j], out[i]);
      if (j < i) out[j] = fma(a[k], v[i], out[j]);
    }
}

/// What products of the form read: the tangent alone, the same for all laws.
struct ProjectedTangent {
  template <class T>
  struct Tangent {
    T matrix[45];  ///< lower triangle by rows
  };
  template <class T>
  static M3<T> differential(const Tangent<T>& t, const M3<T>&, const M3<T>& df) {
    T v[9], out[9];
    list(df, v);
    multiplySymmetric(t.matrix, v, out);
    return matrixOf(out);
  }
};

template <class Law_>
struct Projected : Mjed<Law_> {
  using Base = Mjed<Law_>;
  template <class T>
  using Tangent = ProjectedTangent::Tangent<T>;

  template <class T>
  [[gnu::noipa]] static M3<T> stress(const ParametersOf<Law_, T>& parameters, T weight, const M3<T>& f, Tangent<T>& t) {
    typename Base::template Tangent<T> exact_tangent;
    const M3<T> p = Base::stress(parameters, weight, f, exact_tangent);
    T full[9][9];
#pragma GCC unroll 1
    for (int k = 0; k < 9; ++k)
      columnOf(
          k, [&](const M3<T>& df) { return Base::differential(parameters, weight, exact_tangent, f, df); }, full[k]);
    projectNegative(full);  // the weight is minus a volume
    for (int i = 0, k = 0; i < 9; ++i)
      for (int j = 0; j <= i; ++j) t.matrix[k++] = full[i][j];
    return p;
  }
  template <class T>
  static M3<T> differential(const ParametersOf<Law_, T>&, T, const Tangent<T>& t, const M3<T>& f, const M3<T>& df) {
    return ProjectedTangent::differential(t, f, df);
  }
};

/// S and D, times the weight, are the tangent: the law's invariants matter no more.
struct StandardTangent {
  template <class T>
  struct Tangent {
    S3<T> s;
    T d[21];  ///< lower triangle of D by rows
  };
  template <class T>
  static M3<T> differential(const Tangent<T>& t, const M3<T>& f, const M3<T>& df) {
    const S3<T> dc = metricDifferential(f, df);
    const T half(0.5), e[6] = {half * dc.xx, half * dc.yy, half * dc.zz, dc.xy, dc.yz, dc.zx};
    T ds[6];
    multiplySymmetric(t.d, e, ds);
    return timesSymmetric(df, t.s) + timesSymmetric(f, S3<T>{ds[0], ds[1], ds[2], ds[3], ds[4], ds[5]});
  }
};

template <class Law_>
struct Standard : Mjed<Law_> {
  using Base = Mjed<Law_>;
  template <class T>
  using Tangent = StandardTangent::Tangent<T>;

  template <class T>
  static M3<T> stress(const ParametersOf<Law_, T>& parameters, T weight, const M3<T>& f, Tangent<T>& t) {
    S3<T> s;
    Elasticity<T> d{};
    Base::secondStress(parameters, f, s, d);
    t.s = s * weight;
    for (int i = 0, k = 0; i < 6; ++i)
      for (int j = 0; j <= i; ++j) t.d[k++] = weight * d.d[i][j];
    return timesSymmetric(f, t.s);
  }
  template <class T>
  static M3<T> differential(const ParametersOf<Law_, T>&, T, const Tangent<T>& t, const M3<T>& f, const M3<T>& df) {
    return StandardTangent::differential(t, f, df);
  }
};

}  // namespace stroma::hyperelastic
