// SPDX-License-Identifier: LGPL-2.1-or-later
// Hexahedra of any shape, small strains with or without rotations: models for ModelKernels (model_kernels.h) that visit
// the 2x2x2 Gauss points.
#pragma once
#include "components/elasticity/hexahedron_matrix.h"
#include "components/elasticity/hexahedron_rest.h"

namespace stroma::hexahedron {

/// What a product reads: gradients in world axes at the last force (of the rest shape before the first), and the law.
/// 592 bytes with LocalDilatation, 624 with the node numbers.
template <template <class> class Law>
struct PointTangent {
  template <class T>
  struct Of {
    Gradients<T> g[8];
    Law<T> law;
  };
};

/// E U for an upper triangular U.
template <class T>
M3<T> timesUpper(const M3<T>& e, const T (&u)[6]) {
  return {e.c0 * u[0], fma(u[1], e.c0, e.c1 * u[2]), fma(u[3], e.c0, fma(u[4], e.c1, e.c2 * u[5]))};
}

/// Any shape, gradients at each of the 2x2x2 Gauss points; the tangent keeps them in world axes, so that a product
/// needs no rotation.
template <template <class> class Law>
struct PointModel : HexahedronModel {
  using Products = PointModel;
  template <class T>
  using Rest = PointRest<T>;
  template <class T>
  using Tangent = typename PointTangent<Law>::template Of<T>;

  template <class T>
  static void product(const PointRest<T>&, const Tangent<T>& t, T factor, const V3<T> (&)[8], const V3<T> (&dx)[8],
                      V3<T> (&df)[8]) {
    nodesOf(stiffnessProduct(t.g, t.law, factor, modesOf(dx)), df);
  }
  template <class T>
  static void matrix(const PointRest<T>&, const Tangent<T>& t, const V3<T> (&)[8], T (&k)[8 * 8 * 9]) {
    stiffnessMatrix(t.g, t.law.lambda, t.law.mu, k);
    if constexpr (requires { t.law.bulk; }) addMeanMatrix(t.g, t.law.root, t.law.bulk, k);
  }
};

/// method = small.
template <template <class> class Law>
struct PointLinear : PointModel<Law> {
  template <class T>
  using Tangent = typename PointTangent<Law>::template Of<T>;
  template <class T>
  static void force(const PointRest<T>& rest, const Tangent<T>& t, const V3<T> (&x)[8], V3<T> (&f)[8]) {
    nodesOf(stiffnessProduct(t.g, t.law, T(1.), modesOf(x) - rest.modes), f);
  }
  template <class T>
  static T energy(const PointRest<T>& rest, const Tangent<T>& t, const V3<T> (&x)[8]) {
    return elementEnergy(t.g, t.law, atPoints(modesOf(x) - rest.modes));
  }
};

/// R, J and J - R J_0 of a shape; gradients of each Gauss point on demand.
template <class Rotation, Update update, class T>
struct Kinematics {
  /// F of the mean edges, and its rotation R.
  M3<T> deformation, rotation;
  /// J (only where B is updated) and J - R J_0 at the Gauss points, made of modes.
  PointValues<T> j, d;

  Kinematics(const PointRest<T>& rest, const V3<T> (&x)[8]) {
    const Modes<T> m = modesOf(x);
    deformation = timesUpper(meanEdges(m), rest.inverse_edges);
    rotation = rotationOf<Rotation>(deformation, meanEdges(m), meanEdges(rest.modes));
    if constexpr (update != Update::none) j = atPoints(m);
    d = atPoints(m - rotated(rotation, rest.modes));
  }
  /// w^1/2 / 8 times the gradients g_i of hexahedron.h at Gauss point p, in world axes; with B and V the weight is
  /// |det J|.
  Gradients<T> gradients(const PointRest<T>& rest, int p) const {
    if constexpr (update == Update::none) return elastic::rotated(rotation, rest.g[p]);
    const M3<T> c = Columns<T>(j, p).matrix(), n = cofactor(c);
    T scale = rest.scale[p];
    const T inverse = rest.inverse_determinant[p];
    if (any(abs(inverse) > T(0.))) scale = volumeScale(stroma::dot(c.c0, n.c0) * inverse, scale);
    return {n.c0 * scale, n.c1 * scale, n.c2 * scale};
  }
};

/// method = large, polar, svd with the warped tangent.
template <template <class> class Law, class Rotation, Update update>
struct PointCorotational : PointModel<Law> {
  template <class T>
  using Tangent = typename PointTangent<Law>::template Of<T>;
  template <class T>
  static void force(const PointRest<T>& rest, Tangent<T>& t, const V3<T> (&x)[8], V3<T> (&f)[8]) {
    const Kinematics<Rotation, update, T> k(rest, x);
    for (int p = 0; p < 8; ++p) t.g[p] = k.gradients(rest, p);
    const T pressure = meanPressure(t.law, k.d, t.g);
    PointValues<T> forces;
    for (int p = 0; p < 8; ++p)
      addStress(stressAt(t.law, p, strainOf(Columns<T>(k.d, p).d, t.g[p]), T(1.), pressure), t.g[p], p, forces);
    nodesOf(fromPoints(forces), f);
  }
  template <class T>
  static T energy(const PointRest<T>& rest, const Tangent<T>& t, const V3<T> (&x)[8]) {
    const Kinematics<Rotation, update, T> k(rest, x);
    Gradients<T> g[8];
    for (int p = 0; p < 8; ++p) g[p] = k.gradients(rest, p);
    return elementEnergy(g, t.law, k.d);
  }
};

/// The same with the exact tangent: dR and dg are differentiated at the x of the last force.
template <template <class> class Law, class Rotation, Update update>
struct ExactPointCorotational : PointCorotational<Law, Rotation, update> {
  using Forces = PointCorotational<Law, Rotation, update>;
  using Products = ExactPointCorotational;
  static constexpr bool reads_position = true;
  template <class T>
  using Tangent = typename PointTangent<Law>::template Of<T>;
  template <class T>
  static void product(const PointRest<T>& rest, const Tangent<T>& t, T factor, const V3<T> (&x)[8],
                      const V3<T> (&dx)[8], V3<T> (&df)[8]) {
    const Kinematics<Rotation, update, T> k(rest, x);
    const Modes<T> dm = modesOf(dx);
    const M3<T> dr = Rotation::differential(k.deformation, k.rotation, timesUpper(meanEdges(dm), rest.inverse_edges));
    const PointValues<T> dj = atPoints(dm), dd = atPoints(dm - rotated(dr, rest.modes));
    Gradients<T> g[8], dg[8];
    for (int p = 0; p < 8; ++p) g[p] = k.gradients(rest, p), dg[p] = differential(k, rest, dr, dj, p);
    const T pressure = meanPressure(t.law, k.d, g);
    const T dpressure = meanPressure(t.law, dd, g) + meanPressure(t.law, k.d, dg);
    PointValues<T> forces;
    for (int p = 0; p < 8; ++p) {
      const Columns<T> d(k.d, p), change(dd, p);
      const S3<T> dstrain = strainOf(change.d, g[p]) + strainOf(d.d, dg[p]);
      addStress(stressAt(t.law, p, dstrain, factor, dpressure), g[p], p, forces);
      addStress(stressAt(t.law, p, strainOf(d.d, g[p]), factor, pressure), dg[p], p, forces);
    }
    nodesOf(fromPoints(forces), df);
  }
  /// Where B stays: what the warped tangent has, and what comes of the rotation. Else by products. It is not symmetric.
  template <class T>
  static void matrix(const PointRest<T>& rest, const Tangent<T>& t, const V3<T> (&x)[8], T (&k)[8 * 8 * 9])
    requires(update == Update::none)
  {
    PointModel<Law>::matrix(rest, t, x, k);
    addTurningOf(rest, t, x, k);
  }

 private:
  template <class T>
  [[gnu::noipa, gnu::flatten]] static void addTurningOf(const PointRest<T>& rest, const Tangent<T>& t, const V3<T> (&x)[8],
                                                        T (&k)[8 * 8 * 9]) {
    const Kinematics<Rotation, update, T> now(rest, x);
    const T pressure = meanPressure(t.law, now.d, t.g), one(1.);
    V3<T> forces[8][3], spins[8][3];
    for (int a = 0; a < 8; ++a) {
      V3<T> unit[8];
      unit[a].x = one;
      const M3<T> df = timesUpper(meanEdges(modesOf(unit)), rest.inverse_edges);
      spinsAlong<Rotation>(now.deformation, now.rotation, V3<T>{df.c0.x, df.c1.x, df.c2.x}, spins[a]);
    }
    for (int m = 0; m < 3; ++m) {
      const M3<T> dr = turnedAbout(now.rotation, m);
      const PointValues<T> dd = atPoints(Modes<T>() - rotated(dr, rest.modes));
      Gradients<T> dg[8];
      for (int p = 0; p < 8; ++p) dg[p] = elastic::rotated(dr, rest.g[p]);
      const T dpressure = meanPressure(t.law, now.d, dg) + meanPressure(t.law, dd, t.g);
      PointValues<T> points;
      for (int p = 0; p < 8; ++p) {
        const Columns<T> d(now.d, p), change(dd, p);
        const S3<T> dstrain = strainOf(change.d, t.g[p]) + strainOf(d.d, dg[p]);
        addStress(stressAt(t.law, p, dstrain, one, dpressure), t.g[p], p, points);
        addStress(stressAt(t.law, p, strainOf(d.d, t.g[p]), one, pressure), dg[p], p, points);
      }
      V3<T> nodes[8];
      nodesOf(fromPoints(points), nodes);
      for (int a = 0; a < 8; ++a) forces[a][m] = nodes[a];
    }
    addTurning(forces, spins, k);
  }
  /// dg of Gauss point p for changes dR and dJ.
  template <class T>
  static Gradients<T> differential(const Kinematics<Rotation, update, T>& k, const PointRest<T>& rest, const M3<T>& dr,
                                   const PointValues<T>& dj, int p) {
    if constexpr (update == Update::none) return elastic::rotated(dr, rest.g[p]);
    const Columns<T> c(k.j, p), dc(dj, p);
    const V3<T>(&e)[3] = c.d, (&de)[3] = dc.d;
    const M3<T> n = cofactor(c.matrix());
    const M3<T> dn{cross(de[1], e[2]) + cross(e[1], de[2]), cross(de[2], e[0]) + cross(e[2], de[0]),
                   cross(de[0], e[1]) + cross(e[0], de[1])};
    T scale = rest.scale[p], dscale(0.);
    if (const T inverse = rest.inverse_determinant[p]; any(abs(inverse) > T(0.))) {
      const T ratio = stroma::dot(e[0], n.c0) * inverse;
      const T dratio = (stroma::dot(de[0], n.c0) + stroma::dot(de[1], n.c1) + stroma::dot(de[2], n.c2)) * inverse;
      dscale = volumeScaleDifferential(ratio, dratio, scale);
      scale = volumeScale(ratio, scale);
    }
    return {dn.c0 * scale + n.c0 * dscale, dn.c1 * scale + n.c1 * dscale, dn.c2 * scale + n.c2 * dscale};
  }
};

}  // namespace stroma::hexahedron
