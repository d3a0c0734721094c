// SPDX-License-Identifier: LGPL-2.1-or-later
// The mathematics of a triangle that resists only in its own plane, free of meshes and nodes.
//
// Vertices 0, 1, 2; edges e_i = x_i - x_0. The rest shape is stored in its own frame (first edge on its first axis), so
// that D_m is upper triangular, and F = [e_1 e_2] D_m^-1 has two columns. With orthonormal axes r_0, r_1 in space, m_ab
// = r_a . F_b. Large: r_0 along F_0, r_1 in the plane of the triangle (QR), so that m_10 = 0. Small: the axes of the
// rest shape. Strain eps = sym(m) - I, stress sigma = D eps, energy W = V/2 sigma : eps.
//
// The force of the large variant is exactly -dW/dx, so that it has no resultant and no moment. With the spin w = m_10 /
// m_00 of the frame, dW = V P : dm with
//   P_00 = sigma_00,  P_01 = sigma_01,  P_11 = sigma_11,  P_10 = (sigma_01 m_11 - sigma_11 m_01) / m_00
// and f_i = -V sum_ab r_a P_ab G_ib, G_i row i of D_m^-1. P_10 differs from sigma_01 in second order of the strain.
#pragma once
#include "components/elasticity/rotation_methods.h"
#include "framework/fem/model_kernels.h"

namespace stroma::membrane {

/// D_m^-1: 00, 01, 11 [1/m].
template <class T>
struct Rest {
  T inverse[3];
};

/// eps_00, eps_11, 2 eps_01, or stresses s_00, s_11, s_01.
template <class T>
struct Plane {
  T xx, yy, xy;
};

/// sigma = lambda tr(eps) I + 2 mu eps [Pa], or [J] where the constants hold a volume.
template <class T>
struct Isotropic {
  T lambda, mu;
  Isotropic scaled(T factor) const { return {factor * lambda, factor * mu}; }
  Plane<T> stress(const Plane<T>& strain) const {
    const T pressure = lambda * (strain.xx + strain.yy), two_mu = mu + mu;
    return {fma(two_mu, strain.xx, pressure), fma(two_mu, strain.yy, pressure), mu * strain.xy};
  }
};

/// sigma = D eps of a sheet with fibres, in the axes of the rest shape; D is symmetric.
template <class T>
struct Fibred {
  T d00, d01, d02, d11, d12, d22;
  Fibred scaled(T factor) const {
    return {factor * d00, factor * d01, factor * d02, factor * d11, factor * d12, factor * d22};
  }
  Plane<T> stress(const Plane<T>& strain) const {
    return {fma(d00, strain.xx, fma(d01, strain.yy, d02 * strain.xy)), fma(d01, strain.xx, fma(d11, strain.yy, d12 * strain.xy)),
            fma(d02, strain.xx, fma(d12, strain.yy, d22 * strain.xy))};
  }
};

/// What a product reads: the axes at the last force evaluation (until then those of the rest shape), D_m^-1, the law in
/// the plane times V_0 [J], and the tension there, the positive part of the stress times V_0 [J].
template <class T, class LawOfT>
struct TangentOf {
  V3<T> axis0, axis1;
  T inverse[3];
  LawOfT law;
  Plane<T> tension;
};

/// Two columns: of F, of its change, of a stress.
template <class T>
struct Columns {
  V3<T> c0, c1;
};

/// F = [e_1 e_2] D_m^-1 of the positions, or its change for a change of them.
template <class T>
Columns<T> gradientOf(const T (&inverse)[3], const V3<T> (&x)[3]) {
  const V3<T> e1 = x[1] - x[0], e2 = x[2] - x[0];
  return {e1 * inverse[0], fma(inverse[1], e1, e2 * inverse[2])};
}
/// f_i = sum_b q_b G_ib, f_0 = -sum
template <class T>
void nodalForces(const T (&inverse)[3], const V3<T>& q0, const V3<T>& q1, V3<T> (&f)[3]) {
  f[1] = fma(inverse[0], q0, q1 * inverse[1]);
  f[2] = q1 * inverse[2];
  f[0] = -(f[1] + f[2]);
}
/// 1/2 sigma : eps
template <class T, class LawOfT>
T energyOf(const Plane<T>& strain, const LawOfT& law) {
  const Plane<T> s = law.stress(strain);
  return T(0.5) * fma(s.xx, strain.xx, fma(s.yy, strain.yy, s.xy * strain.xy));
}

/// The part of a stress with the positive principal stresses.
template <class T>
Plane<T> tensionOf(const Plane<T>& s) {
  const T mean = T(0.5) * (s.xx + s.yy), half = T(0.5) * (s.xx - s.yy), radius = sqrt(half * half + s.xy * s.xy);
  const T larger = maximum(mean + radius, T(0.)), smaller = maximum(mean - radius, T(0.));
  const T middle = T(0.5) * (larger + smaller), scale = T(0.5) * (larger - smaller) / maximum(radius, T(1e-300));
  return {middle + scale * half, middle - scale * half, scale * s.xy};
}

/// The triangle's frame (c2: its normal) and the upper triangular m. A triangle crushed to a line or a point has some
/// frame, and its stretches are kept from zero where they divide.
template <class T>
struct Qr {
  M3<T> r;
  /// m_00, m_01, m_11.
  T u00, u01, u11;
  explicit Qr(const Columns<T>& f)
      : r(rotation::gramSchmidt(M3<T>{f.c0, f.c1, {T(0.), T(0.), T(0.)}})),
        u00(dot(r.c0, f.c0)),
        u01(dot(r.c0, f.c1)),
        u11(dot(r.c1, f.c1)) {}
  /// eps = sym(m) - I
  Plane<T> strain() const { return {u00 - T(1.), u11 - T(1.), u01}; }
  T inverse00() const { return T(1.) / maximum(u00, T(1e-6)); }
  T inverse11() const { return T(1.) / maximum(u11, T(1e-6)); }
  /// P_10 of a stress, see the top of the file.
  T p10(const Plane<T>& s) const { return (s.xy * u11 - s.yy * u01) * inverse00(); }
};

/// What all methods share; products read the axes of the tangent.
template <template <class> class Law>
struct Model {
  static constexpr int nodes = 3;
  static constexpr bool reads_position = false;
  template <class T>
  using Rest = membrane::Rest<T>;
  template <class T>
  using Tangent = TangentOf<T, Law<T>>;

  /// -V r (sigma of sym(r^T dF)) with the axes r held: the whole of a linear triangle.
  template <class T>
  static void product(const Rest<T>&, const Tangent<T>& t, T factor, const V3<T> (&)[3], const V3<T> (&dx)[3],
                      V3<T> (&df)[3]) {
    linearForces(t, strainOf(t, dx), -factor, df);
  }

 protected:
  /// sym(r^T dF)
  template <class T>
  static Plane<T> strainOf(const Tangent<T>& t, const V3<T> (&dx)[3]) {
    const Columns<T> d = gradientOf(t.inverse, dx);
    return {dot(t.axis0, d.c0), dot(t.axis1, d.c1), dot(t.axis0, d.c1) + dot(t.axis1, d.c0)};
  }
  /// Forces of factor * sigma(strain), along the axes of the tangent.
  template <class T>
  static void linearForces(const Tangent<T>& t, const Plane<T>& strain, T factor, V3<T> (&f)[3]) {
    const Plane<T> s = t.law.scaled(factor).stress(strain);
    nodalForces(t.inverse, fma(s.xx, t.axis0, t.axis1 * s.xy), fma(s.xy, t.axis0, t.axis1 * s.yy), f);
  }
};

template <template <class> class Law>
using Storage = StorageOf<Model<Law>>;

/// method = small.
template <template <class> class Law>
struct Linear : Model<Law> {
  using Base = Model<Law>;
  template <class T>
  using Tangent = TangentOf<T, Law<T>>;
  template <class T>
  static void force(const Rest<T>&, Tangent<T>& t, const V3<T> (&x)[3], V3<T> (&f)[3]) {
    Base::linearForces(t, strain(t, x), T(-1.), f);
  }
  template <class T>
  static T energy(const Rest<T>&, const Tangent<T>& t, const V3<T> (&x)[3]) {
    return energyOf(strain(t, x), t.law);
  }

 private:
  template <class T>
  static Plane<T> strain(const Tangent<T>& t, const V3<T> (&x)[3]) {
    const Plane<T> m = Base::strainOf(t, x);
    return {m.xx - T(1.), m.yy - T(1.), m.xy};
  }
};

/// method = large with the warped tangent: the axes held, and across the plane the stiffness that tension gives, which
/// leaves it definite.
template <template <class> class Law>
struct Large : Model<Law> {
  using Base = Model<Law>;
  template <class T>
  using Tangent = TangentOf<T, Law<T>>;
  template <class T>
  static void force(const Rest<T>& rest, Tangent<T>& t, const V3<T> (&x)[3], V3<T> (&f)[3]) {
    const Qr<T> qr(gradientOf(rest.inverse, x));
    t.axis0 = qr.r.c0, t.axis1 = qr.r.c1;
    t.tension = tensionOf(t.law.stress(qr.strain()));
    const Plane<T> s = t.law.scaled(T(-1.)).stress(qr.strain());
    nodalForces(t.inverse, fma(s.xx, qr.r.c0, qr.r.c1 * qr.p10(s)), fma(s.xy, qr.r.c0, qr.r.c1 * s.yy), f);
  }
  template <class T>
  static T energy(const Rest<T>& rest, const Tangent<T>& t, const V3<T> (&x)[3]) {
    return energyOf(Qr<T>(gradientOf(rest.inverse, x)).strain(), t.law);
  }
  template <class T>
  static void product(const Rest<T>& rest, const Tangent<T>& t, T factor, const V3<T> (&x)[3], const V3<T> (&dx)[3],
                      V3<T> (&df)[3]) {
    Base::product(rest, t, factor, x, dx, df);
    const Columns<T> d = gradientOf(t.inverse, dx);
    const V3<T> normal = cross(t.axis0, t.axis1), pull = normal * -factor;
    const T a = dot(normal, d.c0), b = dot(normal, d.c1);
    V3<T> across[3];
    nodalForces(t.inverse, pull * fma(t.tension.xx, a, t.tension.xy * b), pull * fma(t.tension.xy, a, t.tension.yy * b),
                across);
    for (int i = 0; i < 3; ++i) df[i] = df[i] + across[i];
  }
};

/// The strain of the displacement u in the triangle's own frame, sym(grad u), and forces R A0 B^T D B u along it, as in
/// SOFA. B is that of the rest shape or (current) that of the shape of the moment. No energy has these forces.
template <template <class> class Law, bool current>
struct Displaced : Large<Law> {
  using Base = Model<Law>;
  template <class T>
  using Tangent = TangentOf<T, Law<T>>;
  template <class T>
  static void force(const Rest<T>& rest, Tangent<T>& t, const V3<T> (&x)[3], V3<T> (&f)[3]) {
    const Qr<T> qr(gradientOf(rest.inverse, x));
    t.axis0 = qr.r.c0, t.axis1 = qr.r.c1;
    t.tension = {T(0.), T(0.), T(0.)};
    Plane<T> strain = qr.strain();
    if constexpr (current) {
      // m = 1 + grad u against the rest shape; against the present one grad u is 1 - m^-1
      const T i00 = qr.inverse00(), i11 = qr.inverse11(), i01 = -(qr.u01 * i00 * i11);
      t.inverse[0] = rest.inverse[0] * i00;
      t.inverse[1] = fma(rest.inverse[0], i01, rest.inverse[1] * i11);
      t.inverse[2] = rest.inverse[2] * i11;
      strain = {T(1.) - i00, T(1.) - i11, -i01};
    }
    Base::linearForces(t, strain, T(-1.), f);
  }
  /// As long as B is that of the rest shape: the axes held.
  template <class T>
  static void product(const Rest<T>& rest, const Tangent<T>& t, T factor, const V3<T> (&x)[3], const V3<T> (&dx)[3],
                      V3<T> (&df)[3]) {
    Base::product(rest, t, factor, x, dx, df);
  }
};

/// The same with the exact tangent: the turning of the frame included, and with it the stiffness across the plane that
/// tension gives (and compression takes).
template <template <class> class Law>
struct ExactLarge : Large<Law> {
  template <class T>
  using Tangent = TangentOf<T, Law<T>>;
  static constexpr bool reads_position = true;
  template <class T>
  static void product(const Rest<T>& rest, const Tangent<T>& t, T factor, const V3<T> (&x)[3], const V3<T> (&dx)[3],
                      V3<T> (&df)[3]) {
    const Qr<T> qr(gradientOf(rest.inverse, x));
    const Columns<T> d = gradientOf(rest.inverse, dx);
    const auto& [r, u00, u01, u11] = qr;
    const T i00 = qr.inverse00(), i11 = qr.inverse11();
    // the turn of the axes: dr_0 = w r_1 + a n, dr_1 = -w r_0 + b n
    const T w = dot(r.c1, d.c0) * i00, a = dot(r.c2, d.c0) * i00, b = (dot(r.c2, d.c1) - u01 * a) * i11;
    const V3<T> dr0 = fma(w, r.c1, r.c2 * a), dr1 = fma(-w, r.c0, r.c2 * b);
    const T du00 = dot(r.c0, d.c0), du01 = fma(w, u11, dot(r.c0, d.c1)), du11 = dot(r.c1, d.c1) - w * u01;
    const auto law = t.law.scaled(-factor);
    const Plane<T> s = law.stress(qr.strain()), ds = law.stress(Plane<T>{du00, du11, du01});
    const T p10 = qr.p10(s), dp10 = (ds.xy * u11 + s.xy * du11 - ds.yy * u01 - s.yy * du01 - p10 * du00) * i00;
    const V3<T> q0 = fma(ds.xx, r.c0, fma(dp10, r.c1, fma(s.xx, dr0, dr1 * p10)));
    const V3<T> q1 = fma(ds.xy, r.c0, fma(ds.yy, r.c1, fma(s.xy, dr0, dr1 * s.yy)));
    nodalForces(rest.inverse, q0, q1, df);
  }
};

}  // namespace stroma::membrane
