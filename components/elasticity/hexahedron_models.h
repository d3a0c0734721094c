// SPDX-License-Identifier: LGPL-2.1-or-later
// The methods of a mesh of hexahedra: models for ModelKernels (model_kernels.h). Meshes of boxes (of any size and
// orientation) under a constant B have models of their own, four times as fast.
#pragma once
#include "components/elasticity/hexahedron_matrix.h"
#include "framework/fem/model_kernels.h"

namespace stroma::hexahedron {

/// What all share: eight nodes in the order of VTK, products that do not read the position unless a model says so.
struct HexahedronModel {
  static constexpr int nodes = 8;
  static constexpr bool reads_position = false;
};

// ---- boxes ----

/// Edge lengths in the modes' measure: X_xi = 4 a and so on [m].
template <class T>
struct BoxRest {
  T edges[3];
};
/// What a box's product reads: its axes at the last force, and its stiffness. 120 bytes, 152 with the node numbers.
template <class T>
struct BoxTangent {
  M3<T> axes;
  BoxStiffness<T> stiffness;
};

/// Boxes under a constant B. In the axes R of the element (those of the rest shape for method small) modes
/// separate (boxProduct), so that no Gauss point is ever visited but for the matrix.
struct BoxModel : HexahedronModel {
  template <class T>
  using Rest = BoxRest<T>;
  template <class T>
  using Tangent = BoxTangent<T>;

  template <class T>
  static void product(const BoxRest<T>&, const BoxTangent<T>& t, T factor, const V3<T> (&)[8], const V3<T> (&dx)[8],
                      V3<T> (&df)[8]) {
    const M3<T> r = t.axes;
    const Modes<T> own = rotatedBack(r, modesOf(dx));
    nodesOf(rotated(r, boxProduct(t.stiffness, factor, own)), df);
  }

  /// K [i][j][row][column]. The gradients of xi, eta, zeta are the same at all Gauss points of a box.
  template <class T>
  static void matrix(const BoxRest<T>&, const BoxTangent<T>& t, const V3<T> (&)[8], T (&k)[8 * 8 * 9]) {
    const T* inverse = t.stiffness.inverse;
    const T eighth(0.125);  // of the gradients, twice, but for the one that the constants hold
    Gradients<T> g[8];
    for (Gradients<T>& point : g) point = {t.axes.c0 * inverse[0], t.axes.c1 * inverse[1], t.axes.c2 * inverse[2]};
    const BoxStiffness<T>& s = t.stiffness;
    stiffnessMatrix(g, eighth * s.varying, eighth * s.mu, k);
    const T one(1.), roots[8] = {one, one, one, one, one, one, one, one};
    addMeanMatrix(g, roots, eighth * eighth * (s.lambda - s.varying), k);
  }

 protected:
  /// R^T u - X
  template <class T>
  static Modes<T> displacement(const BoxRest<T>& rest, const M3<T>& r, const Modes<T>& m) {
    Modes<T> d = rotatedBack(r, m);
    d.xi.x -= rest.edges[0], d.eta.y -= rest.edges[1], d.zeta.z -= rest.edges[2];
    return d;
  }
  /// f = -R K (R^T u - X), with u the modes m of the positions.
  template <class T>
  static void forceIn(const BoxRest<T>& rest, const BoxTangent<T>& t, const M3<T>& r, const Modes<T>& m,
                      V3<T> (&f)[8]) {
    const Modes<T> own = boxProduct(t.stiffness, T(1.), displacement(rest, r, m));
    nodesOf(rotated(r, own), f);
  }
  /// E = 1/2 (R^T u - X) K (R^T u - X) [J].
  template <class T>
  static T energyIn(const BoxRest<T>& rest, const BoxTangent<T>& t, const M3<T>& r, const Modes<T>& m) {
    const Modes<T> d = displacement(rest, r, m);
    return T(-0.5) * dot(d, boxProduct(t.stiffness, T(1.), d));
  }
  /// F of the mean edges: columns times 1/X.
  template <class T>
  static M3<T> meanDeformation(const BoxTangent<T>& t, const Modes<T>& m) {
    const T* inverse = t.stiffness.inverse;
    const T eighth(0.125);
    return {m.xi * (inverse[0] * eighth), m.eta * (inverse[1] * eighth), m.zeta * (inverse[2] * eighth)};
  }
};

/// method = small: the axes stay those of the rest shape.
struct BoxLinear : BoxModel {
  template <class T>
  static void force(const BoxRest<T>& rest, const BoxTangent<T>& t, const V3<T> (&x)[8], V3<T> (&f)[8]) {
    forceIn(rest, t, t.axes, modesOf(x), f);
  }
  template <class T>
  static T energy(const BoxRest<T>& rest, const BoxTangent<T>& t, const V3<T> (&x)[8]) {
    return energyIn(rest, t, t.axes, modesOf(x));
  }
};

/// method = large, polar, svd with a constant B and the warped tangent.
template <class Rotation>
struct BoxCorotational : BoxModel {
  template <class T>
  static void force(const BoxRest<T>& rest, BoxTangent<T>& t, const V3<T> (&x)[8], V3<T> (&f)[8]) {
    const Modes<T> m = modesOf(x);
    const M3<T> r = Rotation::of(meanDeformation(t, m));
    t.axes = r;
    forceIn(rest, t, r, m, f);
  }
  template <class T>
  static T energy(const BoxRest<T>& rest, const BoxTangent<T>& t, const V3<T> (&x)[8]) {
    const Modes<T> m = modesOf(x);
    return energyIn(rest, t, Rotation::of(meanDeformation(t, m)), m);
  }
};

// ---- any shape ----

/// The rest shape in its own frame (that of its mean edges; world axes for method small). 840 bytes.
template <class T>
struct PointRest {
  T inverse_edges[6];        ///< [X_xi X_eta X_zeta]^-1, upper triangular (00, 01, 11, 02, 12, 22)
  Modes<T> modes;            ///< X
  Gradients<T> g[8];         ///< w^1/2 / 8 times the rows of J_0^-1
  T scale[8];                ///< of the cofactors of a J made of modes: sign(det J_0) / (512 w^1/2)
  T inverse_determinant[8];  ///< of a J_0 made of modes, 512 det J_0
};
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
    rotation = Rotation::of(deformation);
    if constexpr (update != Update::none) j = atPoints(m);
    d = atPoints(m - rotated(rotation, rest.modes));
  }
  /// w^1/2 / 8 times the gradients g_i of hexahedron.h at Gauss point p, in world axes; with B and V the weight is
  /// |det J|.
  Gradients<T> gradients(const PointRest<T>& rest, int p) const {
    if constexpr (update == Update::none) return elastic::rotated(rotation, rest.g[p]);
    const M3<T> c = Columns<T>(j, p).matrix(), n = cofactor(c);
    T scale = rest.scale[p];
    if constexpr (update == Update::strain_displacement_and_volume)
      scale = volumeScale(stroma::dot(c.c0, n.c0) * rest.inverse_determinant[p], scale);
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
template <class Rotation, Update update>
struct ExactPointCorotational : PointCorotational<LocalDilatation, Rotation, update> {
  static constexpr bool reads_position = true;
  template <class T>
  using Tangent = typename PointTangent<LocalDilatation>::template Of<T>;
  template <class T>
  static void product(const PointRest<T>& rest, const Tangent<T>& t, T factor, const V3<T> (&x)[8],
                      const V3<T> (&dx)[8], V3<T> (&df)[8]) {
    const Kinematics<Rotation, update, T> k(rest, x);
    const Modes<T> dm = modesOf(dx);
    const M3<T> dr = Rotation::differential(k.deformation, k.rotation, timesUpper(meanEdges(dm), rest.inverse_edges));
    const PointValues<T> dj = atPoints(dm), dd = atPoints(dm - rotated(dr, rest.modes));
    const T lambda = factor * t.law.lambda, mu = factor * t.law.mu;
    PointValues<T> forces;
    for (int p = 0; p < 8; ++p) {
      const Gradients<T> g = k.gradients(rest, p), dg = differential(k, rest, dr, dj, p);
      const Columns<T> d(k.d, p), change(dd, p);
      addStress(restoringStress(strainOf(change.d, g) + strainOf(d.d, dg), lambda, mu), g, p, forces);
      addStress(restoringStress(strainOf(d.d, g), lambda, mu), dg, p, forces);
    }
    nodesOf(fromPoints(forces), df);
  }
  /// By products: it is not symmetric.
  static void matrix() = delete;

 private:
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
    if constexpr (update == Update::strain_displacement_and_volume) {
      const T inverse = rest.inverse_determinant[p], ratio = stroma::dot(e[0], n.c0) * inverse;
      const T dratio = (stroma::dot(de[0], n.c0) + stroma::dot(de[1], n.c1) + stroma::dot(de[2], n.c2)) * inverse;
      dscale = volumeScaleDifferential(ratio, dratio, scale);
      scale = volumeScale(ratio, scale);
    }
    return {dn.c0 * scale + n.c0 * dscale, dn.c1 * scale + n.c1 * dscale, dn.c2 * scale + n.c2 * dscale};
  }
};

// ---- method = green: St. Venant-Kirchhoff, no rotation. Gradients hold w^1/2 / 8, so that F is w^1/2 F ----

/// Gauss points of any shape.
struct PointShape {
  template <class T>
  using Rest = PointRest<T>;
  template <class T>
  struct Tangent {
    T lambda, mu;  ///< Lame's constants, or -2/3 mu and mu [Pa]
    T bulk;        ///< K/V, or zero without the mean dilatation [Pa/m^3]
  };
  /// 1/w of Gauss point p [1/m^3].
  template <class T>
  static T inverseWeight(const PointRest<T>& rest, const Tangent<T>&, int p) {
    return abs(rest.inverse_determinant[p]) * T(512.);
  }
  template <class T>
  static Gradients<T> gradients(const PointRest<T>& rest, const Tangent<T>&, int p) {
    return rest.g[p];
  }
  /// w^1/2 F at Gauss point p from J at the points.
  template <class T>
  static M3<T> deformation(const PointRest<T>& rest, const Tangent<T>&, const PointValues<T>& j, int p) {
    return outerSum(Columns<T>(j, p).d, rest.g[p]);
  }
  /// Adds the forces of the first Piola-Kirchhoff stress (times w^1/2) at Gauss point p, still as values at points.
  template <class T>
  static void addForces(const PointRest<T>& rest, const Tangent<T>&, const M3<T>& stress, int p, PointValues<T>& f) {
    const Gradients<T>& g = rest.g[p];
    addColumns(stress * g.g1, stress * g.g2, stress * g.g3, p, f);
  }
};

/// Gauss points of a box, in its own axes.
struct BoxShape {
  template <class T>
  using Rest = BoxRest<T>;
  template <class T>
  struct Tangent {
    T gradient[3];     ///< w^1/2 / 8 times 2 / edge length
    T inverse_weight;  ///< 1/w
    T lambda, mu;      ///< Lame's constants, or -2/3 mu and mu [Pa]
    T bulk;            ///< K/V, or zero without the mean dilatation [Pa/m^3]
  };
  template <class T>
  static T inverseWeight(const BoxRest<T>&, const Tangent<T>& t, int) {
    return t.inverse_weight;
  }
  template <class T>
  static Gradients<T> gradients(const BoxRest<T>&, const Tangent<T>& t, int) {
    const T zero(0.);
    return {{t.gradient[0], zero, zero}, {zero, t.gradient[1], zero}, {zero, zero, t.gradient[2]}};
  }
  template <class T>
  static M3<T> deformation(const BoxRest<T>&, const Tangent<T>& t, const PointValues<T>& j, int p) {
    const Columns<T> c(j, p);
    return {c.d[0] * t.gradient[0], c.d[1] * t.gradient[1], c.d[2] * t.gradient[2]};
  }
  template <class T>
  static void addForces(const BoxRest<T>&, const Tangent<T>& t, const M3<T>& stress, int p, PointValues<T>& f) {
    addColumns(stress.c0 * t.gradient[0], stress.c1 * t.gradient[1], stress.c2 * t.gradient[2], p, f);
  }
};

/// `mean`: the volume change is the mean of tr(E) over the element; its stress is F times one pressure.
template <class Shape, bool mean>
struct Green : HexahedronModel {
  static constexpr bool reads_position = true;
  template <class T>
  using Rest = typename Shape::template Rest<T>;
  template <class T>
  using Tangent = typename Shape::template Tangent<T>;

  template <class T>
  static void force(const auto& rest, const auto& t, const V3<T> (&x)[8], V3<T> (&f)[8]) {
    const PointValues<T> j = atPoints(modesOf(x));
    const T pressure = pressureOf(rest, t, j);
    PointValues<T> forces;
    for (int p = 0; p < 8; ++p) {
      const M3<T> deformation = Shape::deformation(rest, t, j, p);
      M3<T> stress = greenStress(deformation, Shape::inverseWeight(rest, t, p), t.lambda, t.mu);
      if constexpr (mean) stress = stress + deformation * pressure;
      Shape::addForces(rest, t, stress, p, forces);
    }
    nodesOf(fromPoints(forces), f);
  }
  template <class T>
  static T energy(const auto& rest, const auto& t, const V3<T> (&x)[8]) {
    const PointValues<T> j = atPoints(modesOf(x));
    T sum(0.), volume_change(0.);
    for (int p = 0; p < 8; ++p) {
      const T inverse_weight = Shape::inverseWeight(rest, t, p);
      const S3<T> strain = greenStrain(Shape::deformation(rest, t, j, p), inverse_weight);
      sum += storedEnergy(strain, t.lambda, t.mu) / inverse_weight;
      volume_change += (strain.xx + strain.yy + strain.zz) / inverse_weight;
    }
    if constexpr (mean) sum += T(0.5) * t.bulk * volume_change * volume_change;
    return sum;
  }
  template <class T>
  static void product(const auto& rest, const auto& t, T factor, const V3<T> (&x)[8], const V3<T> (&dx)[8],
                      V3<T> (&df)[8]) {
    const PointValues<T> j = atPoints(modesOf(x)), dj = atPoints(modesOf(dx));
    const T lambda = factor * t.lambda, mu = factor * t.mu;
    const T pressure = factor * pressureOf(rest, t, j), dpressure = factor * pressureDifferential(rest, t, j, dj);
    PointValues<T> forces;
    for (int p = 0; p < 8; ++p) {
      const M3<T> f = Shape::deformation(rest, t, j, p), change = Shape::deformation(rest, t, dj, p);
      M3<T> stress = greenStressDifferential(f, change, Shape::inverseWeight(rest, t, p), lambda, mu);
      if constexpr (mean) stress = stress + change * pressure + f * dpressure;
      Shape::addForces(rest, t, stress, p, forces);
    }
    nodesOf(fromPoints(forces), df);
  }
  template <class T>
  static void matrix(const auto& rest, const auto& t, const V3<T> (&x)[8], T (&k)[8 * 8 * 9]) {
    const PointValues<T> j = atPoints(modesOf(x));
    const T pressure = pressureOf(rest, t, j);
    Gradients<T> g[8];
    GreenState<T> state[8];
    for (int p = 0; p < 8; ++p) {
      g[p] = Shape::gradients(rest, t, p);
      state[p].f = Shape::deformation(rest, t, j, p);
      state[p].inverse_weight = Shape::inverseWeight(rest, t, p);
      S3<T>& s = state[p].minus_s;
      s = restoringStress(greenStrain(state[p].f, state[p].inverse_weight), t.lambda, t.mu);
      if constexpr (mean) s.xx += pressure, s.yy += pressure, s.zz += pressure;
    }
    greenMatrix(g, state, t.lambda, t.mu, k);
    if constexpr (mean) addMeanMatrix(g, state, t.bulk, k);
  }

 private:
  /// -K/V sum w tr(E)
  template <class T>
  static T pressureOf(const auto& rest, const auto& t, const PointValues<T>& j) {
    if constexpr (!mean) return T(0.);
    T sum(0.);  // tr(F^T F) holds the weight already
    for (int p = 0; p < 8; ++p) {
      const M3<T> f = Shape::deformation(rest, t, j, p);
      sum += T(0.5) * squaredNorm(f) - T(1.5) / Shape::inverseWeight(rest, t, p);
    }
    return -t.bulk * sum;
  }
  template <class T>
  static T pressureDifferential(const auto& rest, const auto& t, const PointValues<T>& j, const PointValues<T>& dj) {
    if constexpr (!mean) return T(0.);
    T sum(0.);
    for (int p = 0; p < 8; ++p) {
      const M3<T> f = Shape::deformation(rest, t, j, p), change = Shape::deformation(rest, t, dj, p);
      sum += stroma::dot(f.c0, change.c0) + (stroma::dot(f.c1, change.c1) + stroma::dot(f.c2, change.c2));
    }
    return -t.bulk * sum;
  }
};

}  // namespace stroma::hexahedron
