// SPDX-License-Identifier: LGPL-2.1-or-later
// Strain, stress and forces at one integration point (framework/fem/gradients.h). The weight of the point is in Lame's
// constants or, as its root, in the gradients.
#pragma once
#include "framework/fem/gradients.h"

namespace stroma::elastic {

/// How much of B follows the deformation: the "no B", "B" and "B and V" rows of Nesme et al. 2005.
enum class Update : int { none, strain_displacement, strain_displacement_and_volume };

/// R g_i
template <class T>
Gradients<T> rotated(const M3<T>& r, const Gradients<T>& g) {
  return {r * g.g1, r * g.g2, r * g.g3};
}

// Strains are held as eps_xx eps_yy eps_zz and 2 eps_xy 2 eps_yz 2 eps_zx.

/// a . b + c . d
template <class T>
T dotSum(T a1, T b1, T a2, T b2, T a3, T b3) {
  return fma(a1, b1, fma(a2, b2, a3 * b3));
}
template <class T>
T dotSum(T a1, T b1, T a2, T b2, T a3, T b3, T rest) {
  return fma(a1, b1, fma(a2, b2, fma(a3, b3, rest)));
}

/// The strain sym(sum d_i (x) g_i).
template <class T>
S3<T> strainOf(const V3<T> (&d)[3], const Gradients<T>& g) {
  return {
      dotSum(d[0].x, g.g1.x, d[1].x, g.g2.x, d[2].x, g.g3.x),
      dotSum(d[0].y, g.g1.y, d[1].y, g.g2.y, d[2].y, g.g3.y),
      dotSum(d[0].z, g.g1.z, d[1].z, g.g2.z, d[2].z, g.g3.z),
      dotSum(d[0].x, g.g1.y, d[1].x, g.g2.y, d[2].x, g.g3.y, dotSum(d[0].y, g.g1.x, d[1].y, g.g2.x, d[2].y, g.g3.x)),
      dotSum(d[0].y, g.g1.z, d[1].y, g.g2.z, d[2].y, g.g3.z, dotSum(d[0].z, g.g1.y, d[1].z, g.g2.y, d[2].z, g.g3.y)),
      dotSum(d[0].z, g.g1.x, d[1].z, g.g2.x, d[2].z, g.g3.x, dotSum(d[0].x, g.g1.z, d[1].x, g.g2.z, d[2].x, g.g3.z))};
}

/// The strain sym(A B^T) of two matrices: columns of A against columns of B.
template <class T>
S3<T> strainOfProduct(const M3<T>& a, const M3<T>& b) {
  const V3<T> d[3] = {a.c0, a.c1, a.c2};
  return strainOf(d, Gradients<T>{b.c0, b.c1, b.c2});
}

/// eps - I; the shear stays.
template <class T>
S3<T> minusIdentity(S3<T> strain) {
  strain.xx -= T(1.), strain.yy -= T(1.), strain.zz -= T(1.);
  return strain;
}

/// -sigma of a strain: sigma = lambda tr(eps) I + 2 mu eps [Pa], or [J] when the constants hold a volume.
template <class T>
S3<T> restoringStress(const S3<T>& strain, T lambda, T mu) {
  const T minus_mu = -mu, minus_two_mu = minus_mu + minus_mu;
  const T pressure = -lambda * (strain.xx + strain.yy + strain.zz);
  return {fma(minus_two_mu, strain.xx, pressure),
          fma(minus_two_mu, strain.yy, pressure),
          fma(minus_two_mu, strain.zz, pressure),
          minus_mu * strain.xy,
          minus_mu * strain.yz,
          minus_mu * strain.zx};
}

/// 1/2 sigma : eps
template <class T>
T storedEnergy(const S3<T>& strain, T lambda, T mu) {
  const T half(0.5), trace = strain.xx + strain.yy + strain.zz;
  const T normal = dotSum(strain.xx, strain.xx, strain.yy, strain.yy, strain.zz, strain.zz);
  const T shear = dotSum(strain.xy, strain.xy, strain.yz, strain.yz, strain.zx, strain.zx);
  return half * lambda * trace * trace + mu * fma(half, shear, normal);
}

/// The scale of the normals n_i in g_i for "B and V", from `ratio` = V/V_0 and the scale without V. A flat element
/// would make it infinite: |ratio| is not taken below this. The paper's remedy is not to update V; the bound is ours.
constexpr double smallest_volume_ratio = 1e-3;

/// scale / |ratio|^1/2, with the sign of the ratio.
template <class T>
T volumeScale(T ratio, T scale) {
  ratio = select(abs(ratio) < T(smallest_volume_ratio),
                 select(ratio < T(0.), T(-smallest_volume_ratio), T(smallest_volume_ratio)), ratio);
  return scale * select(ratio < T(0.), T(-1.), T(1.)) / sqrt(abs(ratio));
}
/// Its derivative for a change `dratio`.
template <class T>
T volumeScaleDifferential(T ratio, T dratio, T scale) {
  const auto bounded = abs(ratio) < T(smallest_volume_ratio);
  return select(bounded, T(0.), T(-0.5) * volumeScale(ratio, scale) * dratio / select(bounded, T(1.), ratio));
}

// ---- St. Venant-Kirchhoff: E = (F^T F - I)/2, S = lambda tr(E) I + 2 mu E, P = F S, W = lambda/2 tr(E)^2 + mu E : E
// Gradients that hold the root of a weight w make F into w^1/2 F; then `inverse_weight` is 1/w, and E and S are true.

/// E with doubled shear.
template <class T>
S3<T> greenStrain(const M3<T>& f, T inverse_weight) {
  const T half = T(0.5) * inverse_weight, minus_half(-0.5);
  return {fma(half, dot(f.c0, f.c0), minus_half), fma(half, dot(f.c1, f.c1), minus_half),
          fma(half, dot(f.c2, f.c2), minus_half), inverse_weight * dot(f.c0, f.c1),
          inverse_weight * dot(f.c1, f.c2),       inverse_weight * dot(f.c2, f.c0)};
}
/// dE with doubled shear.
template <class T>
S3<T> greenStrainDifferential(const M3<T>& f, const M3<T>& df, T inverse_weight) {
  const auto shear = [&](const V3<T>& a, const V3<T>& da, const V3<T>& b, const V3<T>& db) {
    return inverse_weight * (dot(a, db) + dot(da, b));
  };
  return {inverse_weight * dot(f.c0, df.c0), inverse_weight * dot(f.c1, df.c1), inverse_weight * dot(f.c2, df.c2),
          shear(f.c0, df.c0, f.c1, df.c1),   shear(f.c1, df.c1, f.c2, df.c2),   shear(f.c2, df.c2, f.c0, df.c0)};
}

/// -P of F.
template <class T>
M3<T> greenStress(const M3<T>& f, T inverse_weight, T lambda, T mu) {
  return timesSymmetric(f, restoringStress(greenStrain(f, inverse_weight), lambda, mu));
}
/// -dP = -(dF S + F dS)
template <class T>
M3<T> greenStressDifferential(const M3<T>& f, const M3<T>& df, T inverse_weight, T lambda, T mu) {
  const S3<T> minus_s = restoringStress(greenStrain(f, inverse_weight), lambda, mu);
  const S3<T> minus_ds = restoringStress(greenStrainDifferential(f, df, inverse_weight), lambda, mu);
  return timesSymmetric(df, minus_s) + timesSymmetric(f, minus_ds);
}

}  // namespace stroma::elastic
