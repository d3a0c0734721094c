// SPDX-License-Identifier: LGPL-2.1-or-later
// Models for ModelKernels of hexahedra whose stiffness K at rest acts on the modes u of their corners, in axes that turn with the cell:
//   f = -R K (R^T x - X),   df = -R K R^T dx,   or df with tangent = exact the whole derivative, by the chain rule.
// No Gauss point is visited. `Cells` has the K of a kind of cells:
//   Rest<T>, Tangent<T>                      as in ElementStorage; the tangent has the axes R of the last force
//   product(rest, tangent, factor, own)      -factor K of modes in the axes of the cell
//   displacement(rest, r, m)                 R^T u - X of the modes m of the positions
//   deformation(rest, tangent, edges)        F of mean edges
//   restEdges(rest)                          the mean edges at rest
// and may have matrix(rest, tangent, k) and diagonal(tangent, k) in the axes of the world.
#pragma once
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
  static void matrix(const Rest<T>& rest, const Tangent<T>& t, const V3<T> (&)[8], T (&k)[8 * 8 * 9])
    requires requires { Cells::matrix(rest, t, k); }
  {
    Cells::matrix(rest, t, k);
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
  /// Made of products: those of the warped tangent are another's.
  template <class T>
  static void matrix(const Rest<T>&, const Tangent<T>&, const V3<T> (&)[8], T (&)[8 * 8 * 9]) = delete;
  template <class T>
  static void diagonal(const Tangent<T>&, T (&)[8 * 9]) = delete;
};

}  // namespace stroma::hexahedron
