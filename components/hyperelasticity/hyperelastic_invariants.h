// SPDX-License-Identifier: LGPL-2.1-or-later
// Sets of invariants on which an energy can depend besides J = det F, and what follows from an energy's derivatives:
//   P = psi_J cof F + F S,           S = 2 sum_a psi_a dI_a/dC                    (no C^-1 anywhere)
//   dP = dpsi_J cof F + psi_J dcof F + dF S + F dS,   dS = 2 sum_a (dpsi_a dI_a/dC + psi_a d(dI_a/dC))
// with dpsi_x = psi_xJ dJ + sum_b psi_xb dI_b, dJ = cof F : dF and C = F^T F. Source: S. Marchesseau, T. Heimann,
// S. Chatelin, R. Willinger, H. Delingette, "Multiplicative Jacobian energy decomposition method for fast porous
// visco-hyperelastic soft tissue model", MICCAI 2010, sections 2.1 and 2.2, written for F instead of for nodes. The
// same sets give the textbook's S and 4 d2W/dC2, with C^-1, for comparison.
//
// A set has Point<T> (F and the values of J and its invariants, as a tuple too), stress() (P), differential() (dP), and for
// the textbook's form gradients(), dI_a/dC into matrices that come as zero, and curvature(), which adds 4 sum psi_a d2I_a/dC2.
#pragma once
#include <tuple>

#include "components/hyperelasticity/hyperelastic_tensors.h"

namespace stroma::hyperelastic {

/// What every set has of F.
template <class T>
struct VolumePoint {
  M3<T> f, cof;
  T j;
  explicit VolumePoint(const M3<T>& deformation)
      : f(deformation), cof(cofactor(deformation)), j(stroma::dot(deformation.c0, cof.c0)) {}
};

/// A law's energy at a point, with its derivatives by J and the invariants.
template <class Law>
auto jetOfEnergy(const auto& point, const auto& parameters) {
  return [&]<int... k>(std::integer_sequence<int, k...>, const auto& invariants) {
    return Law::energy(variable<k>(std::get<k>(invariants))..., parameters);
  }(std::make_integer_sequence<int, std::tuple_size_v<decltype(point.invariants())>>(), point.invariants());
}
/// The same number alone.
template <class Law>
auto energyAt(const auto& point, const auto& parameters) {
  return std::apply([&](const auto&... invariant) { return Law::energy(invariant..., parameters); }, point.invariants());
}

/// J and I1 = tr C.
struct First {
  static constexpr bool anisotropic = false;
  template <class T>
  struct Point : VolumePoint<T> {
    T i1;
    template <class Parameters>
    Point(const M3<T>& deformation, const Parameters&) : VolumePoint<T>(deformation), i1(squaredNorm(deformation)) {}
    auto invariants() const { return std::tie(this->j, i1); }
  };
  template <class T>
  static M3<T> stress(const Point<T>& p, const auto& w) {
    return scaled(2. * w.b, p.f) + scaled(w.a, p.cof);
  }
  template <class T>
  static M3<T> differential(const Point<T>& p, const auto& w, const M3<T>& df) {
    const T half_di1 = dot(p.f, df), di1 = half_di1 + half_di1, dj = dot(p.cof, df);
    const auto dfirst = w.ab * dj + w.bb * di1;
    const auto dvolume = w.aa * dj + w.ab * di1;
    return (scaled(2. * w.b, df) + scaled(w.a, cofactorDifferential(p.f, df))) +
           (scaled(2. * dfirst, p.f) + scaled(dvolume, p.cof));
  }
  template <class T>
  static void gradients(const Point<T>&, S3<T> (&a)[3]) {
    a[0] = unit<T>();
  }
  template <class T>
  static void curvature(const auto&, const auto&, Elasticity<T>&) {}
};

/// J, I1 and I2 = ((tr C)^2 - tr C^2)/2; dI2/dC = I1 Id - C.
struct FirstAndSecond {
  static constexpr bool anisotropic = false;
  template <class T>
  struct Point : VolumePoint<T> {
    S3<T> c;
    T i1, i2;
    template <class Parameters>
    Point(const M3<T>& deformation, const Parameters&) : VolumePoint<T>(deformation), c(metric(deformation)) {
      i1 = c.xx + c.yy + c.zz;
      const T minors = fma(c.xx, c.yy, fma(c.yy, c.zz, c.zz * c.xx)) - fma(c.xy, c.xy, fma(c.yz, c.yz, c.zx * c.zx));
      i2 = minors;
    }
    auto invariants() const { return std::tie(this->j, i1, i2); }
  };
  /// a Id + b C
  template <class T>
  static S3<T> combination(const Point<T>& p, T a, T b) {
    S3<T> s = p.c * b;
    s.xx += a, s.yy += a, s.zz += a;
    return s;
  }
  template <class T>
  static S3<T> secondStress(const Point<T>& p, const auto& w) {
    const T minus_second = -2. * w.c;
    return combination(p, T(2. * w.b - minus_second * p.i1), minus_second);
  }
  template <class T>
  static M3<T> stress(const Point<T>& p, const auto& w) {
    return timesSymmetric(p.f, secondStress(p, w)) + scaled(w.a, p.cof);
  }
  template <class T>
  static M3<T> differential(const Point<T>& p, const auto& w, const M3<T>& df) {
    const S3<T> dc = metricDifferential(p.f, df);
    const T di1 = dc.xx + dc.yy + dc.zz, di2 = p.i1 * di1 - dot(p.c, dc), dj = dot(p.cof, df);
    const auto dfirst = w.ab * dj + (w.bb * di1 + w.bc * di2);
    const auto dsecond = w.ac * dj + (w.bc * di1 + w.cc * di2);
    const auto dvolume = w.aa * dj + (w.ab * di1 + w.ac * di2);
    const T on_unit = 2. * (dfirst + (dsecond * p.i1 + w.c * di1));
    S3<T> ds = dc * (-2. * w.c) + scaled(-2. * dsecond, p.c);
    ds.xx += on_unit, ds.yy += on_unit, ds.zz += on_unit;
    return (timesSymmetric(df, secondStress(p, w)) + timesSymmetric(p.f, ds)) +
           (scaled(w.a, cofactorDifferential(p.f, df)) + scaled(dvolume, p.cof));
  }
  template <class T>
  static void gradients(const Point<T>& p, S3<T> (&a)[3]) {
    a[0] = unit<T>(), a[1] = combination(p, p.i1, T(-1.));
  }
  /// 4 psi_2 (Id (x) Id - symmetric identity)
  template <class T>
  static void curvature(const auto&, const auto& w, Elasticity<T>& d) {
    const T s = 4. * w.c, minus_half = -0.5 * s;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j)
        if (i != j) d.d[i][j] += s;
      d.d[3 + i][3 + i] += minus_half;
    }
  }
};

/// J, I1 and I4 = a C a, a the first axis of the frame of F.
struct FirstAndFibre {
  static constexpr bool anisotropic = true;
  template <class T>
  struct Point : VolumePoint<T> {
    T i1, i4;
    template <class Parameters>
    Point(const M3<T>& deformation, const Parameters&)
        : VolumePoint<T>(deformation), i1(squaredNorm(deformation)), i4(stroma::dot(deformation.c0, deformation.c0)) {}
    auto invariants() const { return std::tie(this->j, i1, i4); }
  };
  template <class T>
  static M3<T> stress(const Point<T>& p, const auto& w) {
    M3<T> stress = scaled(2. * w.b, p.f) + scaled(w.a, p.cof);
    stress.c0 = fma(T(2. * w.c), p.f.c0, stress.c0);
    return stress;
  }
  template <class T>
  static M3<T> differential(const Point<T>& p, const auto& w, const M3<T>& df) {
    const T half_di4 = stroma::dot(p.f.c0, df.c0), di4 = half_di4 + half_di4;
    const T half_di1 = dot(p.f, df), di1 = half_di1 + half_di1, dj = dot(p.cof, df);
    const auto dfirst = w.ab * dj + (w.bb * di1 + w.bc * di4);
    const auto dfibre = w.ac * dj + (w.bc * di1 + w.cc * di4);
    const auto dvolume = w.aa * dj + (w.ab * di1 + w.ac * di4);
    M3<T> out = (scaled(2. * w.b, df) + scaled(w.a, cofactorDifferential(p.f, df))) +
                (scaled(2. * dfirst, p.f) + scaled(dvolume, p.cof));
    out.c0 = out.c0 + (df.c0 * (2. * w.c) + p.f.c0 * (2. * dfibre));
    return out;
  }
  template <class T>
  static void gradients(const Point<T>&, S3<T> (&a)[3]) {
    a[0] = unit<T>(), a[1].xx = T(1.);
  }
  template <class T>
  static void curvature(const auto&, const auto&, Elasticity<T>&) {}
};

/// J and Q = sum b_ij E_ij^2 over all i, j, E = (C - Id)/2 in the fibres' frame: parameters has bff, bss, bnn, bfs,
/// bsn, bfn, with axes f, s, n = x, y, z. dQ/dC = b E (product by component).
struct Quadratic {
  static constexpr bool anisotropic = true;
  template <class T, class Parameters>
  static S3<T> weighted(const S3<T>& e, const Parameters& b) {
    return {b.bff * e.xx, b.bss * e.yy, b.bnn * e.zz, b.bfs * e.xy, b.bsn * e.yz, b.bfn * e.zx};
  }
  template <class T>
  struct Point : VolumePoint<T> {
    S3<T> be;  ///< b E
    S3<T> b;   ///< b
    T q;
    template <class Parameters>
    Point(const M3<T>& deformation, const Parameters& parameters) : VolumePoint<T>(deformation) {
      const T half(0.5);
      S3<T> e = metric(deformation) * half;
      e.xx -= half, e.yy -= half, e.zz -= half;
      b = {parameters.bff, parameters.bss, parameters.bnn, parameters.bfs, parameters.bsn, parameters.bfn};
      be = weighted(e, parameters);
      q = dot(be, e);
    }
    auto invariants() const { return std::tie(this->j, q); }
  };
  template <class T>
  static M3<T> stress(const Point<T>& p, const auto& w) {
    return timesSymmetric(p.f, p.be * (2. * w.b)) + scaled(w.a, p.cof);
  }
  template <class T>
  static M3<T> differential(const Point<T>& p, const auto& w, const M3<T>& df) {
    const S3<T> dc = metricDifferential(p.f, df);
    const T dq = dot(p.be, dc), dj = dot(p.cof, df);
    const auto dquadratic = w.ab * dj + w.bb * dq, dvolume = w.aa * dj + w.ab * dq;
    const T first = 2. * w.b, second = 2. * dquadratic;
    const S3<T> ds =
        p.be * second +
        S3<T>{p.b.xx * dc.xx, p.b.yy * dc.yy, p.b.zz * dc.zz, p.b.xy * dc.xy, p.b.yz * dc.yz, p.b.zx * dc.zx} * w.b;
    return (timesSymmetric(df, p.be * first) + timesSymmetric(p.f, ds)) +
           (scaled(w.a, cofactorDifferential(p.f, df)) + scaled(dvolume, p.cof));
  }
  template <class T>
  static void gradients(const Point<T>& p, S3<T> (&a)[3]) {
    a[0] = p.be;
  }
  /// 2 psi_Q b on the diagonal: dS = 2 psi_Q b dE, doubled shear halves.
  template <class T>
  static void curvature(const Point<T>& p, const auto& w, Elasticity<T>& d) {
    T b[6];
    list(p.b, b);
    for (int i = 0; i < 6; ++i) d.d[i][i] += (i < 3 ? 2. : 1.) * w.b * b[i];
  }
};

}  // namespace stroma::hyperelastic
