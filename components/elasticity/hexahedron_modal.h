// SPDX-License-Identifier: LGPL-2.1-or-later
// Models for ModelKernels of hexahedra whose stiffness K at rest acts on the modes u of their corners, in axes that turn with the cell:
//   f = -R K (R^T x - X),   df = -R K R^T dx,   or df with tangent = exact the whole derivative, by the chain rule.
// No Gauss point is visited. `Cells` has the K of a kind of cells:
//   Rest<T>, Tangent<T>                      as in ElementStorage; the tangent has the axes R of the last force
//   product(rest, tangent, factor, own)      -factor K of modes in the axes of the cell
//   displacement(rest, r, m)                 R^T u - X of the modes m of the positions
//   deformation(rest, tangent, edges)        F of mean edges
//   restEdges(rest)                          the mean edges at rest
//   column(rest, tangent, i)                 column i of -K, or matrix(rest, tangent, k): all of it, in the axes of the world
// and may have diagonal(tangent, k).
#pragma once
#include "components/elasticity/hexahedron_modal_matrix.h"
#include "components/elasticity/hexahedron_rest.h"

namespace stroma::hexahedron {

/// What all share; by itself method = small, whose axes stay those of the rest shape.
template <class Cells>
struct ModalLinear : HexahedronModel {
  using Products = ModalLinear;
  template <class T>
  using Rest = typename Cells::template Rest<T>;
  template <class T>
  using Tangent = typename Cells::template Tangent<T>;

  template <class T>
  static void force(const Rest<T>& rest, const Tangent<T>& t, const V3<T> (&x)[8], V3<T> (&f)[8]) {
    forceIn(rest, t, t.axes, modesOf(x), f);
  }
  template <class T>
  static T energy(const Rest<T>& rest, const Tangent<T>& t, const V3<T> (&x)[8]) {
    return energyIn(rest, t, t.axes, modesOf(x));
  }
  template <class T>
  static void product(const Rest<T>& rest, const Tangent<T>& t, T factor, const V3<T> (&)[8], const V3<T> (&dx)[8],
                      V3<T> (&df)[8]) {
    const M3<T> r = t.axes;
    nodesOf(rotated(r, Cells::product(rest, t, factor, rotatedBack(r, modesOf(dx)))), df);
  }
  template <class T>
  static void matrix(const Rest<T>& rest, const Tangent<T>& t, const V3<T> (&)[8], T (&k)[8 * 8 * 9]) {
    if constexpr (requires { Cells::matrix(rest, t, k); }) {
      Cells::matrix(rest, t, k);
    } else {
      Modes<T> columns[21];
      for (int i = 0; i < 21; ++i) columns[i] = Cells::column(rest, t, i);
      matrixOfModes(columns, t.axes, k);
    }
  }
  template <class T>
  static void diagonal(const Tangent<T>& t, T (&k)[8 * 9])
    requires requires { Cells::diagonal(t, k); }
  {
    Cells::diagonal(t, k);
  }

 protected:
  /// f = -R K (R^T u - X), with u the modes m of the positions.
  template <class T>
  static void forceIn(const Rest<T>& rest, const Tangent<T>& t, const M3<T>& r, const Modes<T>& m, V3<T> (&f)[8]) {
    nodesOf(rotated(r, Cells::product(rest, t, T(1.), Cells::displacement(rest, r, m))), f);
  }
  /// E = 1/2 (R^T u - X) K (R^T u - X) [J].
  template <class T>
  static T energyIn(const Rest<T>& rest, const Tangent<T>& t, const M3<T>& r, const Modes<T>& m) {
    const Modes<T> d = Cells::displacement(rest, r, m);
    return T(-0.5) * dot(d, Cells::product(rest, t, T(1.), d));
  }
};

/// method = large, polar, svd with the warped tangent.
template <class Cells, class Rotation>
struct ModalCorotational : ModalLinear<Cells> {
  template <class T>
  using Rest = typename Cells::template Rest<T>;
  template <class T>
  using Tangent = typename Cells::template Tangent<T>;
  using Base = ModalLinear<Cells>;
  template <class T>
  static void force(const Rest<T>& rest, Tangent<T>& t, const V3<T> (&x)[8], V3<T> (&f)[8]) {
    const Modes<T> m = modesOf(x);
    t.axes = axesNow(rest, t, m);
    Base::forceIn(rest, t, t.axes, m, f);
  }
  template <class T>
  static T energy(const Rest<T>& rest, const Tangent<T>& t, const V3<T> (&x)[8]) {
    const Modes<T> m = modesOf(x);
    return Base::energyIn(rest, t, axesNow(rest, t, m), m);
  }

 private:
  template <class T>
  static M3<T> axesNow(const Rest<T>& rest, const Tangent<T>& t, const Modes<T>& m) {
    return rotationOf<Rotation>(Cells::deformation(rest, t, meanEdges(m)), meanEdges(m), Cells::restEdges(rest));
  }
};

/// The same with the exact tangent, d = R^T x - X:  df = -dR K d - R K (R^T dx + dR^T x).
template <class Cells, class Rotation>
struct ExactModalCorotational : ModalCorotational<Cells, Rotation> {
  using Forces = ModalCorotational<Cells, Rotation>;
  using Products = ExactModalCorotational;
  static constexpr bool reads_position = true;
  template <class T>
  using Rest = typename Cells::template Rest<T>;
  template <class T>
  using Tangent = typename Cells::template Tangent<T>;
  template <class T>
  static void product(const Rest<T>& rest, const Tangent<T>& t, T factor, const V3<T> (&x)[8], const V3<T> (&dx)[8],
                      V3<T> (&df)[8]) {
    const Modes<T> m = modesOf(x), dm = modesOf(dx);
    const M3<T> f = Cells::deformation(rest, t, meanEdges(m)), r = Rotation::of(f);
    const M3<T> dr = Rotation::differential(f, r, Cells::deformation(rest, t, meanEdges(dm)));
    const Modes<T> own = Cells::product(rest, t, factor, Cells::displacement(rest, r, m));
    const Modes<T> change = Cells::product(rest, t, factor, rotatedBack(r, dm) + rotatedBack(dr, m));
    nodesOf(rotated(dr, own) + rotated(r, change), df);
  }
  /// What the warped tangent has, and what comes of the rotation. It is not symmetric.
  template <class T>
  static void matrix(const Rest<T>& rest, const Tangent<T>& t, const V3<T> (&x)[8], T (&k)[8 * 8 * 9]) {
    Forces::matrix(rest, t, x, k);
    addTurningOf(rest, t, x, k);
  }
  template <class T>
  static void diagonal(const Tangent<T>&, T (&)[8 * 9]) = delete;  // that of the warped tangent is another

 private:
  template <class T>
  [[gnu::noipa, gnu::flatten]] static void addTurningOf(const Rest<T>& rest, const Tangent<T>& t, const V3<T> (&x)[8],
                                                        T (&k)[8 * 8 * 9]) {
    const Modes<T> m = modesOf(x), own = Cells::product(rest, t, T(1.), Cells::displacement(rest, t.axes, m));
    const M3<T> r = t.axes, f = Cells::deformation(rest, t, meanEdges(m));
    V3<T> forces[8][3], spins[8][3];
    for (int a = 0; a < 8; ++a) {
      V3<T> unit[8];
      unit[a].x = T(1.);
      const M3<T> df = Cells::deformation(rest, t, meanEdges(modesOf(unit)));
      spinsAlong<Rotation>(f, r, V3<T>{df.c0.x, df.c1.x, df.c2.x}, spins[a]);
    }
    for (int q = 0; q < 3; ++q) {
      const M3<T> dr = turnedAbout(r, q);
      V3<T> nodes[8];
      nodesOf(rotated(dr, own) + rotated(r, Cells::product(rest, t, T(1.), rotatedBack(dr, m))), nodes);
      for (int a = 0; a < 8; ++a) forces[a][q] = nodes[a];
    }
    addTurning(forces, spins, k);
  }
};

}  // namespace stroma::hexahedron
