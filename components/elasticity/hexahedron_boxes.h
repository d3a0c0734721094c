// SPDX-License-Identifier: LGPL-2.1-or-later
// Boxes (of any size and orientation) under a constant B, for the models of hexahedron_modal.h: in their axes the modes separate
// (boxProduct), which makes them four times as fast as cells of any shape.
#pragma once
#include "components/elasticity/hexahedron_box_product.h"
#include "components/elasticity/hexahedron_matrix.h"
#include "components/elasticity/hexahedron_modal.h"

namespace stroma::hexahedron {

/// A product reads the axes at the last force, and the stiffness.
template <template <class> class Stiffness>
struct BoxCells {
  template <class T>
  using Rest = BoxRest<T>;
  template <class T>
  struct Tangent {
    M3<T> axes;
    Stiffness<T> stiffness;
  };
  template <class T>
  static Modes<T> product(const BoxRest<T>&, const Tangent<T>& t, T factor, const Modes<T>& own) {
    return boxProduct(t.stiffness, factor, own);
  }
  template <class T>
  static Modes<T> displacement(const BoxRest<T>& rest, const M3<T>& r, const Modes<T>& m) {
    Modes<T> d = rotatedBack(r, m);
    d.xi.x -= rest.edges[0], d.eta.y -= rest.edges[1], d.zeta.z -= rest.edges[2];
    return d;
  }
  /// Columns times 1/X.
  template <class T>
  static M3<T> deformation(const BoxRest<T>&, const Tangent<T>& t, const M3<T>& edges) {
    const T eighth(0.125), *inverse = t.stiffness.inverse;
    return {edges.c0 * (inverse[0] * eighth), edges.c1 * (inverse[1] * eighth), edges.c2 * (inverse[2] * eighth)};
  }
  template <class T>
  static M3<T> restEdges(const BoxRest<T>& rest) {
    const T none(0.);
    return {{rest.edges[0], none, none}, {none, rest.edges[1], none}, {none, none, rest.edges[2]}};
  }
};

/// 128 bytes a product.
using IncompatibleBoxes = BoxCells<IncompatibleBoxStiffness>;

/// 120 bytes a product, 152 with the node numbers.
struct Boxes : BoxCells<BoxStiffness> {
  /// K [i][j][row][column]. The gradients of xi, eta, zeta are the same at all Gauss points of a box.
  template <class T>
  static void matrix(const BoxRest<T>&, const Tangent<T>& t, T (&k)[8 * 8 * 9]) {
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
  static void diagonal(const Tangent<T>& t, T (&k)[8 * 9]) {
    boxDiagonal(t.stiffness, t.axes, k);
  }
};

}  // namespace stroma::hexahedron
