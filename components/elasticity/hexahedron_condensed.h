// SPDX-License-Identifier: LGPL-2.1-or-later
// Models of hexahedra with incompatible modes. The modes are condensed out of each cell at rest (hexahedron_incompatible.h), so that
//   f = -R K (R^T x - X),   df = -R K R^T dx,   or df with tangent = exact the whole derivative, by the chain rule,
// with K in the 21 numbers of Modes. K of a box falls apart as in hexahedron_box_product.h: of what varies along xi, the modes a_xi take
// all strain with an x in it until no stress is left there, so that a plane yz bends as if it were free.
#pragma once
#include "components/elasticity/hexahedron_box_product.h"
#include "components/elasticity/hexahedron_points.h"

namespace stroma::hexahedron {

/// H = [., b j, c k] varies along the first axis, where all stress on that axis is zero: adds -sigma_y j to fb and -sigma_z k to fc.
template <class T>
void addPlane(const V3<T>& b, const V3<T>& c, T j, T k, T plane, T mu, V3<T>& fb, V3<T>& fc) {
  const T yy = b.y * j, zz = c.z * k, minus_two_mu = -(mu + mu);
  const T pressure = plane * (yy + zz), yz = -(mu * fma(b.z, j, c.y * k));
  fb.y = fma(j, fma(minus_two_mu, yy, -pressure), fb.y), fb.z = fma(j, yz, fb.z);
  fc.y = fma(k, yz, fc.y), fc.z = fma(k, fma(minus_two_mu, zz, -pressure), fc.z);
}

/// As BoxStiffness: `varying` is of what varies along two axes. `plane` is lambda of plane stress, 2 lambda mu / (lambda + 2 mu),
/// times w/8.
template <class T>
struct IncompatibleBox {
  T inverse[3], lambda, plane, varying, mu;
};
/// -factor K of a box's modes in its own axes.
template <class T>
Modes<T> boxProduct(const IncompatibleBox<T>& box, T factor, const Modes<T>& m) {
  const T i = box.inverse[0], j = box.inverse[1], k = box.inverse[2], third(1. / 3), minus_ninth(-1. / 9);
  const T lambda = factor * box.lambda, mu = factor * box.mu, plane3 = factor * box.plane * third, mu3 = mu * third;
  Modes<T> f{};
  const S3<T> strain{m.xi.x * i,
                     m.eta.y * j,
                     m.zeta.z * k,
                     fma(m.xi.y, i, m.eta.x * j),
                     fma(m.eta.z, j, m.zeta.y * k),
                     fma(m.zeta.x, k, m.xi.z * i)};
  const S3<T> s = restoringStress(strain, lambda, mu);
  f.xi = V3<T>{s.xx, s.xy, s.zx} * i, f.eta = V3<T>{s.xy, s.yy, s.yz} * j, f.zeta = V3<T>{s.zx, s.yz, s.zz} * k;
  // along xi: columns y, z; eta: columns z, x; zeta: columns x, y
  addPlane(m.xi_eta, m.zeta_xi, j, k, plane3, mu3, f.xi_eta, f.zeta_xi);
  V3<T> fa{}, fb{}, fc{}, fd{};
  addPlane(cycled(m.eta_zeta), cycled(m.xi_eta), k, i, plane3, mu3, fa, fb);
  addPlane(cycledBack(m.zeta_xi), cycledBack(m.eta_zeta), i, j, plane3, mu3, fc, fd);
  f.xi_eta = f.xi_eta + cycledBack(fb), f.zeta_xi = f.zeta_xi + cycled(fc), f.eta_zeta = cycledBack(fa) + cycled(fd);
  const T ii = i * i, jj = j * j, kk = k * k, shear = mu * (ii + jj + kk), direct = fma(factor, box.varying, mu);
  f.all = {minus_ninth * fma(direct, ii, shear) * m.all.x, minus_ninth * fma(direct, jj, shear) * m.all.y,
           minus_ninth * fma(direct, kk, shear) * m.all.z};
  return f;
}

/// Boxes: 128 bytes a product, 8 more than without the modes.
struct IncompatibleBoxes {
  template <class T>
  using Rest = BoxRest<T>;
  template <class T>
  struct Tangent {
    M3<T> axes;
    IncompatibleBox<T> stiffness;
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
  /// F of the mean edges.
  template <class T>
  static M3<T> deformation(const BoxRest<T>&, const Tangent<T>& t, const M3<T>& edges) {
    const T eighth(0.125), *inverse = t.stiffness.inverse;
    return {edges.c0 * (inverse[0] * eighth), edges.c1 * (inverse[1] * eighth), edges.c2 * (inverse[2] * eighth)};
  }
};

/// Any shape: the upper triangle of K, row by row. 1,920 bytes a product. Not inlined: element loops are flattened, and a copy in each
/// takes the compiler long.
struct CondensedCells {
  static constexpr int numbers = 21;
  template <class T>
  struct Rest {
    T inverse_edges[6];  ///< as in PointRest
    Modes<T> modes;      ///< X
    T k[numbers * (numbers + 1) / 2];
  };
  template <class T>
  struct Tangent {
    M3<T> axes;
  };
  template <class T>
  [[gnu::noipa, gnu::flatten]] static Modes<T> product(const Rest<T>& rest, const Tangent<T>&, const T& factor, const Modes<T>& own) {
    T in[numbers], out[numbers];
    int n = 0;
    Modes<T> result{};
    forEachMode(own, result, [&](const V3<T>& v, V3<T>&) { in[n] = v.x, in[n + 1] = v.y, in[n + 2] = v.z, n += 3; });
    for (int i = 0; i < numbers; ++i) out[i] = T(0.);
    const T* k = rest.k;
    for (int i = 0; i < numbers; ++i) {
      T sum = *k++ * in[i];
      for (int j = i + 1; j < numbers; ++j, ++k) sum = fma(*k, in[j], sum), out[j] = fma(*k, in[i], out[j]);
      out[i] = out[i] + sum;
    }
    n = 0;
    const T minus = -factor;
    forEachMode(result, own, [&](V3<T>& v, const V3<T>&) { v = V3<T>{out[n], out[n + 1], out[n + 2]} * minus, n += 3; });
    return result;
  }
  template <class T>
  static Modes<T> displacement(const Rest<T>& rest, const M3<T>& r, const Modes<T>& m) {
    return rotatedBack(r, m) - rest.modes;
  }
  template <class T>
  static M3<T> deformation(const Rest<T>& rest, const Tangent<T>&, const M3<T>& edges) {
    return timesUpper(edges, rest.inverse_edges);
  }
};

/// What all share; by itself method = small, whose axes stay those of the rest shape.
template <class Cells>
struct Condensed : HexahedronModel {
  using Products = Condensed;
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

 protected:
  template <class T>
  static void forceIn(const Rest<T>& rest, const Tangent<T>& t, const M3<T>& r, const Modes<T>& m, V3<T> (&f)[8]) {
    nodesOf(rotated(r, Cells::product(rest, t, T(1.), Cells::displacement(rest, r, m))), f);
  }
  template <class T>
  static T energyIn(const Rest<T>& rest, const Tangent<T>& t, const M3<T>& r, const Modes<T>& m) {
    const Modes<T> d = Cells::displacement(rest, r, m);
    return T(-0.5) * dot(d, Cells::product(rest, t, T(1.), d));
  }
};

/// method = large, polar, svd with the warped tangent.
template <class Cells, class Rotation>
struct CondensedCorotational : Condensed<Cells> {
  template <class T>
  using Rest = typename Cells::template Rest<T>;
  template <class T>
  using Tangent = typename Cells::template Tangent<T>;
  using Base = Condensed<Cells>;
  template <class T>
  static void force(const Rest<T>& rest, Tangent<T>& t, const V3<T> (&x)[8], V3<T> (&f)[8]) {
    const Modes<T> m = modesOf(x);
    t.axes = Rotation::of(Cells::deformation(rest, t, meanEdges(m)));
    Base::forceIn(rest, t, t.axes, m, f);
  }
  template <class T>
  static T energy(const Rest<T>& rest, const Tangent<T>& t, const V3<T> (&x)[8]) {
    const Modes<T> m = modesOf(x);
    return Base::energyIn(rest, t, Rotation::of(Cells::deformation(rest, t, meanEdges(m))), m);
  }
};

/// The same with the exact tangent, d = R^T x - X:  df = -dR K d - R K (R^T dx + dR^T x).
template <class Cells, class Rotation>
struct ExactCondensed : CondensedCorotational<Cells, Rotation> {
  using Forces = CondensedCorotational<Cells, Rotation>;
  using Products = ExactCondensed;
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
};

}  // namespace stroma::hexahedron
