// SPDX-License-Identifier: LGPL-2.1-or-later
// The mathematics of a corotational linear tetrahedron, free of meshes and nodes. Source: Nesme et al. 2005, sections 2
// and 3 and appendix A, in the form below.
//
// Vertices a, b, c, d; edges e_i = x_i - x_a, i = 1..3. The rest shape is stored in a frame of its own (which one
// matters to method large alone: rotation::Qr takes the frame's first two axes along): rest edges X_i, and gradients
// G_i of the shape functions of vertex i, so that F = sum e_i (x) G_i. R = rotation of F; g_i the gradients in world
// axes (g_a = -sum).
//   B not updated:      g_i = R G_i                                  H = F R^T - I = sum e_i (x) g_i - I
//   B updated:          g_i = n_i / 6V_0,  n_1 = e_2 x e_3, ...      H = sum (e_i - R X_i) (x) g_i
//   B and V updated:    g_i = n_i / 6V scaled by (V/V_0)^1/2, which turns the weight V_0 below into V
// strain eps = sym H (all in world axes: for an isotropic law R B^T D B R^T = B(Rg)^T D B(Rg)), stress
// sigma = lambda tr(eps) I + 2 mu eps, force f_i = -V_0 sigma g_i, f_a = -sum. The tangent with R and g held ("warped")
// is the same map from dx: one function serves both.
#pragma once
#include <cmath>
#include <type_traits>

#include "components/elasticity/rotation_methods.h"
#include "components/elasticity/strain.h"
#include "framework/fem/isotropic.h"
#include "framework/fem/tetrahedron.h"

namespace stroma::tetrahedron {

/// The rest shape as far as a method reads it: the root (mu V_0)^1/2 [J^1/2] that the gradients of a Tangent hold;
template <class T>
struct RestRoot {
  T root;
};
/// and G_i [1/m], for methods that keep B;
template <class T>
struct RestGradients {
  Gradients<T> g;
  T root;
};
/// and X_i [m], 1/6V_0 [1/m^3] (V_0 signed), for those that update it.
template <class T>
struct RestShape {
  Gradients<T> g;
  T root;
  V3<T> edges[3];
  T inverse_six_volume;
  T of_volume;  ///< the same where V is updated too, else 0
};
/// Warping by node weighs F by 1/6V_0 and takes it with the gradients of its tangent.
template <class T>
struct RestVolume {
  T inverse_six_volume;
};
/// What corotational methods with this update read.
template <Update update, class T>
using RestOf = std::conditional_t<update == Update::none, RestGradients<T>, RestShape<T>>;

/// What a product reads: (mu V_0)^1/2 g_i in world axes [J^1/2/m] at the last force evaluation, and lambda/mu. Large
/// meshes wait for memory: 80 bytes per element, 90 with the node numbers of a fan.
template <class T>
struct Tangent {
  Gradients<T> g;
  T ratio;
};

/// The same where gradients and constants are needed apart: g_i [1/m], Lame's constants times V_0 [J].
template <class T>
struct WorldGradients {
  Gradients<T> g;
  T lambda, mu;
};

/// Lame's constants times V_0 [J], for methods whose products make the rest from the positions.
template <class T>
struct Constants {
  T lambda, mu;
};

/// The tangent at rest of an element with the world gradients `g`, constants [Pa] and weight V_0 [m^3]; zero weight is
/// an element without stiffness.
inline void setTangent(Tangent<double>& t, const Gradients<double>& g, Lame lame, double volume) {
  const double root = std::sqrt(lame.mu * volume);
  t = {{g.g1 * root, g.g2 * root, g.g3 * root}, lame.mu > 0 ? lame.lambda / lame.mu : 0};
}
/// The same for the other tangents.
inline void setTangent(WorldGradients<double>& t, const Gradients<double>& g, Lame lame, double volume) {
  t = {g, lame.lambda * volume, lame.mu * volume};
}
inline void setTangent(Constants<double>& t, const Gradients<double>&, Lame lame, double volume) {
  t = {lame.lambda * volume, lame.mu * volume};
}

/// f_i = s g_i, f_a = -sum, for s = -V_0 sigma.
template <class T>
void nodalForces(const S3<T>& s, const Gradients<T>& g, V3<T> (&f)[4]) {
  f[1] = s * g.g1;
  f[2] = s * g.g2;
  f[3] = s * g.g3;
  f[0] = -(f[1] + f[2] + f[3]);
}

/// df = -factor (B^T D B) dx with the gradients of the tangent: the warped tangent, and the whole of a linear element.
template <class T>
void stiffnessProduct(const auto& t, T factor, const V3<T> (&dx)[4], V3<T> (&df)[4]) {
  const V3<T> d[3] = {dx[1] - dx[0], dx[2] - dx[0], dx[3] - dx[0]};
  nodalForces(restoringStress(strainOf(d, t.g), factor * t.ratio, factor), t.g, df);
}

/// What a force evaluation makes of an element: R, g, and d_i of the strain sym(sum d_i (x) g_i) (- I without an update
/// of B, whose H is sum e_i (x) g_i - I). Linear in d, so that a product in the same pass adds factor de_i to d_i.
template <class T>
struct Kinematics {
  M3<T> rotation;
  Gradients<T> g;
  V3<T> d[3];
};

/// From the edges e_i [m]; the table at the top of the file says what the updates are.
template <class Rotation, Update update, class T>
Kinematics<T> kinematics(const RestOf<update, T>& rest, const V3<T> (&e)[3]) {
  Kinematics<T> k;
  k.rotation = Rotation::of(outerSum(e, rest.g));
  if constexpr (update == Update::none) {
    k.g = rotated(k.rotation, rest.g);
    for (int i = 0; i < 3; ++i) k.d[i] = e[i];
  } else {
    const M3<T> n = cofactor(M3<T>{e[0], e[1], e[2]});
    T scale = rest.inverse_six_volume;
    if (any(abs(rest.of_volume) > T(0.))) scale = volumeScale(dot(e[0], n.c0) * rest.of_volume, rest.of_volume);
    k.g = {n.c0 * scale, n.c1 * scale, n.c2 * scale};
    for (int i = 0; i < 3; ++i) k.d[i] = e[i] - k.rotation * rest.edges[i];
  }
  return k;
}
/// The same at x [m].
template <class Rotation, Update update, class T>
Kinematics<T> kinematics(const RestOf<update, T>& rest, const V3<T> (&x)[4]) {
  return kinematics<Rotation, update>(rest, Edges<T>(x).e);
}

/// The strain times `one`, for gradients g that hold the same factor: 1, or the root (mu V_0)^1/2.
template <Update update, class T>
S3<T> strainOfKinematics(const V3<T> (&d)[3], const Gradients<T>& g, T one) {
  S3<T> strain = strainOf(d, g);
  if constexpr (update == Update::none) strain.xx -= one, strain.yy -= one, strain.zz -= one;
  return strain;
}

/// Strain and gradients at x, and their derivatives in a direction: dR and dg included.
template <class T>
struct Variation {
  S3<T> strain, dstrain;
  Gradients<T> g, dg;
};
template <class Rotation, Update update, class T>
Variation<T> variation(const RestOf<update, T>& rest, const V3<T> (&x)[4], const V3<T> (&dx)[4]) {
  const Kinematics<T> k = kinematics<Rotation, update>(rest, x);
  const Edges<T> edges(x), dedges(dx);
  const auto &e = edges.e, &de = dedges.e;
  const M3<T> dr = Rotation::differential(outerSum(e, rest.g), k.rotation, outerSum(de, rest.g));
  Gradients<T> dg;
  V3<T> dd[3] = {de[0], de[1], de[2]};
  if constexpr (update == Update::none) {
    dg = rotated(dr, rest.g);
  } else {
    const M3<T> n = cofactor(M3<T>{e[0], e[1], e[2]});
    const M3<T> dn{cross(de[1], e[2]) + cross(e[1], de[2]), cross(de[2], e[0]) + cross(e[2], de[0]),
                   cross(de[0], e[1]) + cross(e[0], de[1])};
    T scale = rest.inverse_six_volume, dscale(0.);
    if (const T inverse = rest.of_volume; any(abs(inverse) > T(0.))) {
      const T ratio = dot(e[0], n.c0) * inverse;
      const T dratio = (dot(de[0], n.c0) + dot(de[1], n.c1) + dot(de[2], n.c2)) * inverse;
      scale = volumeScale(ratio, inverse);
      dscale = volumeScaleDifferential(ratio, dratio, inverse);
    }
    dg = {dn.c0 * scale + n.c0 * dscale, dn.c1 * scale + n.c1 * dscale, dn.c2 * scale + n.c2 * dscale};
    for (int i = 0; i < 3; ++i) dd[i] = de[i] - dr * rest.edges[i];
  }
  return {strainOfKinematics<update>(k.d, k.g, T(1.)), strainOf(dd, k.g) + strainOf(k.d, dg), k.g, dg};
}

/// df = derivative of the force in the direction dx at x.
template <class Rotation, Update update, class T>
void exactProduct(const RestOf<update, T>& rest, T lambda, T mu, const V3<T> (&x)[4], const V3<T> (&dx)[4],
                  V3<T> (&df)[4]) {
  const Variation<T> v = variation<Rotation, update>(rest, x, dx);
  V3<T> from_strain[4], from_gradients[4];
  nodalForces(restoringStress(v.dstrain, lambda, mu), v.g, from_strain);
  nodalForces(restoringStress(v.strain, lambda, mu), v.dg, from_gradients);
  for (int a = 0; a < 4; ++a) df[a] = from_strain[a] + from_gradients[a];
}

}  // namespace stroma::tetrahedron
