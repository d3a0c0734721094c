// SPDX-License-Identifier: LGPL-2.1-or-later
// The mathematics of a corotational linear tetrahedron, free of meshes and nodes. Source: Nesme et al. 2005, sections 2
// and 3 and appendix A, in the form below.
//
// Vertices a, b, c, d; edges e_i = x_i - x_a, i = 1..3. The rest shape is stored in its own frame (first edge on x,
// second in the xy plane), so the rest edges are the columns of an upper triangular D_m, and F = [e_1 e_2 e_3] D_m^-1.
// R = rotation of F; g_i the gradient of the shape function of vertex i (g_a = -sum), in world axes.
//   B not updated:      g_i = R G_i,  G_i row i of D_m^-1            H = F R^T - I
//   B updated:          g_i = n_i / 6V_0,  n_1 = e_2 x e_3, ...      H = sum (e_i - R X_i) (x) g_i
//   B and V updated:    g_i = n_i / 6V scaled by (V/V_0)^1/2, which turns the weight V_0 below into V
// strain eps = sym H (all in world axes: for an isotropic law R B^T D B R^T = B(Rg)^T D B(Rg)), stress
// sigma = lambda tr(eps) I + 2 mu eps, force f_i = -V_0 sigma g_i, f_a = -sum. The tangent with R and g held ("warped")
// is the same map from dx: one function serves both.
#pragma once
#include "framework/fem/rotation.h"

namespace stroma::tetrahedron {

/// How much of B follows the deformation: the paper's "no B", "B" and "B and V" rows.
enum class Update : int { none, strain_displacement, strain_displacement_and_volume };

/// The rest shape: D_m^-1 and D_m, both upper triangular (00, 01, 11, 02, 12, 22), and 1/6V_0 [1/m^3] (V_0 signed).
template <class T>
struct Rest {
  T inverse[6], edges[6], inverse_six_volume;
};

/// Gradients g_1, g_2, g_3 [1/m] in world axes.
template <class T>
struct Gradients {
  V3<T> g1, g2, g3;
};

/// sum d_i (x) g_i, columns.
template <class T>
M3<T> outerSum(const V3<T> (&d)[3], const Gradients<T>& g) {
  return {fma(g.g1.x, d[0], fma(g.g2.x, d[1], d[2] * g.g3.x)), fma(g.g1.y, d[0], fma(g.g2.y, d[1], d[2] * g.g3.y)),
          fma(g.g1.z, d[0], fma(g.g2.z, d[1], d[2] * g.g3.z))};
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

template <class T>
S3<T> minusIdentity(S3<T> strain) {
  strain.xx -= T(1.), strain.yy -= T(1.), strain.zz -= T(1.);
  return strain;
}

/// -V_0 sigma of a strain; `lambda`, `mu` are Lame's constants times V_0 [J].
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

/// f_i = s g_i, f_a = -sum, for s = -V_0 sigma.
template <class T>
void nodalForces(const S3<T>& s, const Gradients<T>& g, V3<T> (&f)[4]) {
  f[1] = s * g.g1;
  f[2] = s * g.g2;
  f[3] = s * g.g3;
  f[0] = -(f[1] + f[2] + f[3]);
}

/// df = -(B^T D B) dx with the gradients g: the warped tangent, and the whole of a linear element.
template <class T>
void stiffnessProduct(const Gradients<T>& g, T lambda, T mu, const V3<T> (&dx)[4], V3<T> (&df)[4]) {
  const V3<T> d[3] = {dx[1] - dx[0], dx[2] - dx[0], dx[3] - dx[0]};
  nodalForces(restoringStress(strainOf(d, g), lambda, mu), g, df);
}

/// F = D_s D_m^-1; also dF for differences of vertices.
template <class T>
M3<T> deformationGradient(const Rest<T>& rest, const V3<T> (&e)[3]) {
  const T* i = rest.inverse;
  return {e[0] * i[0], fma(i[1], e[0], e[1] * i[2]), fma(i[3], e[0], fma(i[4], e[1], e[2] * i[5]))};
}

/// R G_i for the upper triangular D_m^-1.
template <class T>
Gradients<T> rotatedRestGradients(const Rest<T>& rest, const M3<T>& r) {
  const T* i = rest.inverse;
  return {fma(i[0], r.c0, fma(i[1], r.c1, r.c2 * i[3])), fma(i[2], r.c1, r.c2 * i[4]), r.c2 * i[5]};
}

/// R X_i: the rest edges in the rotated frame.
template <class T>
void rotatedRestEdges(const Rest<T>& rest, const M3<T>& r, V3<T> (&out)[3]) {
  const T* m = rest.edges;
  out[0] = r.c0 * m[0];
  out[1] = fma(m[1], r.c0, r.c1 * m[2]);
  out[2] = fma(m[3], r.c0, fma(m[4], r.c1, r.c2 * m[5]));
}

/// The scale of n_i in g_i for "B and V": sign(V) / (6 sqrt(|V| |V_0|)). A flat element would make it infinite: |V| is
/// not taken below this part of |V_0|. The paper's remedy is not to update V; this bound is ours.
constexpr double smallest_volume_ratio = 1e-3;

template <class T>
T volumeScale(T six_volume, T inverse_six_volume) {
  T ratio = six_volume * inverse_six_volume;
  ratio = select(abs(ratio) < T(smallest_volume_ratio),
                 select(ratio < T(0.), T(-smallest_volume_ratio), T(smallest_volume_ratio)), ratio);
  return inverse_six_volume * select(ratio < T(0.), T(-1.), T(1.)) / sqrt(abs(ratio));
}

/// What a force evaluation makes of an element: R, g and the strain sym H.
template <class T>
struct Kinematics {
  M3<T> rotation;
  Gradients<T> g;
  S3<T> strain;
};

template <class Rotation, Update update, class T>
Kinematics<T> kinematics(const Rest<T>& rest, const V3<T> (&x)[4]) {
  const V3<T> e[3] = {x[1] - x[0], x[2] - x[0], x[3] - x[0]};
  const M3<T> f = deformationGradient(rest, e);
  Kinematics<T> k;
  k.rotation = Rotation::of(f);
  if constexpr (update == Update::none) {
    k.g = rotatedRestGradients(rest, k.rotation);
    k.strain = minusIdentity(strainOfProduct(f, k.rotation));
  } else {
    const M3<T> n = cofactor(M3<T>{e[0], e[1], e[2]});
    T scale = rest.inverse_six_volume;
    if constexpr (update == Update::strain_displacement_and_volume)
      scale = volumeScale(dot(e[0], n.c0), rest.inverse_six_volume);
    k.g = {n.c0 * scale, n.c1 * scale, n.c2 * scale};
    V3<T> rest_edges[3];
    rotatedRestEdges(rest, k.rotation, rest_edges);
    const V3<T> d[3] = {e[0] - rest_edges[0], e[1] - rest_edges[1], e[2] - rest_edges[2]};
    k.strain = strainOf(d, k.g);
  }
  return k;
}

/// 1/2 V_0 sigma : eps
template <class T>
T storedEnergy(const S3<T>& strain, T lambda, T mu) {
  const T half(0.5), trace = strain.xx + strain.yy + strain.zz;
  const T normal = dotSum(strain.xx, strain.xx, strain.yy, strain.yy, strain.zz, strain.zz);
  const T shear = dotSum(strain.xy, strain.xy, strain.yz, strain.yz, strain.zx, strain.zx);
  return half * lambda * trace * trace + mu * fma(half, shear, normal);
}

/// df = derivative of the force in the direction dx at x: dR and dg included.
template <class Rotation, Update update, class T>
void exactProduct(const Rest<T>& rest, T lambda, T mu, const V3<T> (&x)[4], const V3<T> (&dx)[4], V3<T> (&df)[4]) {
  const Kinematics<T> k = kinematics<Rotation, update>(rest, x);
  const V3<T> e[3] = {x[1] - x[0], x[2] - x[0], x[3] - x[0]};
  const V3<T> de[3] = {dx[1] - dx[0], dx[2] - dx[0], dx[3] - dx[0]};
  const M3<T> f = deformationGradient(rest, e), df_gradient = deformationGradient(rest, de);
  const M3<T> dr = Rotation::differential(f, k.rotation, df_gradient);
  Gradients<T> dg;
  S3<T> dstrain;
  if constexpr (update == Update::none) {
    dg = rotatedRestGradients(rest, dr);
    dstrain = strainOfProduct(df_gradient, k.rotation) + strainOfProduct(f, dr);
  } else {
    const M3<T> n = cofactor(M3<T>{e[0], e[1], e[2]});
    const M3<T> dn{cross(de[1], e[2]) + cross(e[1], de[2]), cross(de[2], e[0]) + cross(e[2], de[0]),
                   cross(de[0], e[1]) + cross(e[0], de[1])};
    T scale = rest.inverse_six_volume, dscale(0.);
    if constexpr (update == Update::strain_displacement_and_volume) {
      const T six_volume = dot(e[0], n.c0), dsix_volume = dot(de[0], n.c0) + dot(de[1], n.c1) + dot(de[2], n.c2);
      scale = volumeScale(six_volume, rest.inverse_six_volume);
      const auto bounded = abs(six_volume * rest.inverse_six_volume) < T(smallest_volume_ratio);
      dscale = select(bounded, T(0.), T(-0.5) * scale * dsix_volume / select(bounded, T(1.), six_volume));
    }
    dg = {dn.c0 * scale + n.c0 * dscale, dn.c1 * scale + n.c1 * dscale, dn.c2 * scale + n.c2 * dscale};
    V3<T> rest_edges[3], drest_edges[3];
    rotatedRestEdges(rest, k.rotation, rest_edges);
    rotatedRestEdges(rest, dr, drest_edges);
    const V3<T> d[3] = {e[0] - rest_edges[0], e[1] - rest_edges[1], e[2] - rest_edges[2]};
    const V3<T> dd[3] = {de[0] - drest_edges[0], de[1] - drest_edges[1], de[2] - drest_edges[2]};
    dstrain = strainOf(dd, k.g) + strainOf(d, dg);
  }
  V3<T> from_strain[4], from_gradients[4];
  nodalForces(restoringStress(dstrain, lambda, mu), k.g, from_strain);
  nodalForces(restoringStress(k.strain, lambda, mu), dg, from_gradients);
  for (int a = 0; a < 4; ++a) df[a] = from_strain[a] + from_gradients[a];
}

}  // namespace stroma::tetrahedron
