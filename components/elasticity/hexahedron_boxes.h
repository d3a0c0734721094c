// SPDX-License-Identifier: LGPL-2.1-or-later
// Boxes (of any size and orientation) under a constant B: models of their own for ModelKernels, four times as fast as
// those for any shape.
#pragma once
#include "components/elasticity/hexahedron_box_product.h"
#include "components/elasticity/hexahedron_matrix.h"
#include "components/elasticity/hexahedron_rest.h"

namespace stroma::hexahedron {

/// What a box's product reads: its axes at the last force, and its stiffness. 120 bytes, 152 with the node numbers.
template <class T>
struct BoxTangent {
  M3<T> axes;
  BoxStiffness<T> stiffness;
};

/// Boxes under a constant B. In the axes R of the element (those of the rest shape for method small) modes
/// separate (boxProduct), so that no Gauss point is ever visited but for the matrix.
struct BoxModel : HexahedronModel {
  using Products = BoxModel;
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
  template <class T>
  static void diagonal(const BoxTangent<T>& t, T (&k)[8 * 9]) {
    boxDiagonal(t.stiffness, t.axes, k);
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
    const M3<T> r = axesNow(rest, t, m);
    t.axes = r;
    forceIn(rest, t, r, m, f);
  }
  template <class T>
  static T energy(const BoxRest<T>& rest, const BoxTangent<T>& t, const V3<T> (&x)[8]) {
    const Modes<T> m = modesOf(x);
    return energyIn(rest, t, axesNow(rest, t, m), m);
  }

 private:
  template <class T>
  static M3<T> axesNow(const BoxRest<T>& rest, const BoxTangent<T>& t, const Modes<T>& m) {
    const T none(0.);
    const M3<T> then{{rest.edges[0], none, none}, {none, rest.edges[1], none}, {none, none, rest.edges[2]}};
    return rotationOf<Rotation>(BoxModel::meanDeformation(t, m), meanEdges(m), then);
  }
};

}  // namespace stroma::hexahedron
