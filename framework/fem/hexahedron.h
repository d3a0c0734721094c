// SPDX-License-Identifier: LGPL-2.1-or-later
// The mathematics of the trilinear hexahedron with 2x2x2 Gauss points, free of meshes and nodes.
//
// Modes. With s_a = (xi_a, eta_a, zeta_a) = (+-1, +-1, +-1) the corners in the order of VTK, the position in an element
// is
//   x = x_0 + xi u_xi + eta u_eta + zeta u_zeta + xi eta u_xi_eta + eta zeta u_eta_zeta + zeta xi u_zeta_xi
//       + xi eta zeta u_all,                        8 u_m = sum_a m(s_a) x_a: 23 sums per component, no products.
// Everything here works with the 21 numbers of 8 u_m ("modes"); forces on modes go back to nodes by the transpose of
// the same sums. Derivatives at the Gauss points (+-1, +-1, +-1)/sqrt 3 follow from modes with 8 multiply-adds a
// component and axis, because the one along xi depends on eta and zeta alone.
//
// Rest shape: modes X in the frame of the mean edges (xi on x, eta in the xy plane); J_0 = dX/d(xi, eta, zeta) at a
// Gauss point and a = J_0^-1, whose rows are the gradients of xi, eta, zeta. F = J a; weight w = |det J_0|. Gradients are
// stored with w^1/2 / 8, so that products need no weight.
// Source: M. Nesme et al. 2005, appendix A.
#pragma once
#include "framework/fem/gradients.h"

namespace stroma::hexahedron {

using namespace elastic;

constexpr double gauss = 0.577350269189625764509;  // 1/sqrt 3

/// 8 u_m, see above; or forces on u_m, over 8. The mean position is left out: nothing depends on it.
template <class T>
struct Modes {
  V3<T> xi, eta, zeta, xi_eta, eta_zeta, zeta_xi, all;
};

/// 8 u_m of the positions, or of any vector at the nodes. 23 sums per component.
template <class T>
Modes<T> modesOf(const V3<T> (&x)[8]) {
  struct Level {  // of one face zeta = const
    V3<T> sum, xi, eta, xi_eta;
    Level(const V3<T>& a, const V3<T>& b, const V3<T>& c, const V3<T>& d) {
      const V3<T> front = b - a, back = c - d, front_sum = a + b, back_sum = c + d;
      sum = back_sum + front_sum, xi = back + front, eta = back_sum - front_sum, xi_eta = back - front;
    }
  };
  const Level low(x[0], x[1], x[2], x[3]), high(x[4], x[5], x[6], x[7]);
  return {high.xi + low.xi,   high.eta + low.eta, high.sum - low.sum,      high.xi_eta + low.xi_eta,
          high.eta - low.eta, high.xi - low.xi,   high.xi_eta - low.xi_eta};
}

/// f_a = sum over modes m(s_a) f_m: the transpose of modesOf.
template <class T>
void nodesOf(const Modes<T>& m, V3<T> (&f)[8]) {
  const auto level = [&](const V3<T>& sum, const V3<T>& xi, const V3<T>& eta, const V3<T>& xi_eta, int first) {
    const V3<T> front = xi - xi_eta, back = xi + xi_eta, front_sum = sum - eta, back_sum = sum + eta;
    f[first] = front_sum - front, f[first + 1] = front_sum + front;
    f[first + 2] = back_sum + back, f[first + 3] = back_sum - back;
  };
  level(-m.zeta, m.xi - m.zeta_xi, m.eta - m.eta_zeta, m.xi_eta - m.all, 0);
  level(m.zeta, m.xi + m.zeta_xi, m.eta + m.eta_zeta, m.xi_eta + m.all, 4);
}

// ---- Gauss points; point p has xi = +- for its first bit, eta for the second, zeta for the third (1: plus) ----

/// Derivatives along the axes at the Gauss points: xi[i] at (eta, zeta) = bits of i, eta[i] at (zeta, xi), zeta[i] at
/// (xi, eta).
template <class T>
struct PointValues {
  V3<T> xi[4], eta[4], zeta[4];
  /// The index of Gauss point p in xi, eta and zeta.
  static constexpr int ofXi(int p) { return p >> 1; }
  static constexpr int ofEta(int p) { return (p >> 2) | (p & 1) << 1; }
  static constexpr int ofZeta(int p) { return p & 3; }
};

/// a + first b + second c + first second d at the four combinations of (+-1/sqrt 3, +-1/sqrt 3).
template <class T>
void bilinear(const V3<T>& a, const V3<T>& b, const V3<T>& c, const V3<T>& d, V3<T> (&out)[4]) {
  const T g(gauss), minus(-gauss);
  const V3<T> a_minus = fma(minus, b, a), a_plus = fma(g, b, a), c_minus = fma(minus, d, c), c_plus = fma(g, d, c);
  out[0] = fma(minus, c_minus, a_minus), out[1] = fma(minus, c_plus, a_plus);
  out[2] = fma(g, c_minus, a_minus), out[3] = fma(g, c_plus, a_plus);
}
/// Its transpose: adds to a, b, c, d.
template <class T>
void bilinearTransposed(const V3<T> (&in)[4], V3<T>& a, V3<T>& b, V3<T>& c, V3<T>& d) {
  const T g(gauss);
  const V3<T> sum_minus = in[2] + in[0], sum_plus = in[3] + in[1];
  const V3<T> difference_minus = (in[2] - in[0]) * g, difference_plus = (in[3] - in[1]) * g;
  a = a + (sum_plus + sum_minus), b = fma(g, sum_plus - sum_minus, b);
  c = c + (difference_plus + difference_minus), d = fma(g, difference_plus - difference_minus, d);
}

/// 8 times the derivatives along xi, eta and zeta at the Gauss points: the columns of J.
template <class T>
PointValues<T> atPoints(const Modes<T>& m) {
  PointValues<T> p;
  bilinear(m.xi, m.xi_eta, m.zeta_xi, m.all, p.xi);
  bilinear(m.eta, m.eta_zeta, m.xi_eta, m.all, p.eta);
  bilinear(m.zeta, m.zeta_xi, m.eta_zeta, m.all, p.zeta);
  return p;
}
/// Forces on modes from values at the points: the transpose of atPoints.
template <class T>
Modes<T> fromPoints(const PointValues<T>& p) {
  Modes<T> m;
  bilinearTransposed(p.xi, m.xi, m.xi_eta, m.zeta_xi, m.all);
  bilinearTransposed(p.eta, m.eta, m.eta_zeta, m.xi_eta, m.all);
  bilinearTransposed(p.zeta, m.zeta, m.zeta_xi, m.eta_zeta, m.all);
  return m;
}

/// J at Gauss point p: its columns.
template <class T>
struct Columns {
  V3<T> d[3];
  Columns(const PointValues<T>& v, int p) : d{v.xi[v.ofXi(p)], v.eta[v.ofEta(p)], v.zeta[v.ofZeta(p)]} {}
  M3<T> matrix() const { return {d[0], d[1], d[2]}; }
};
/// Adds a, b, c to the values along xi, eta, zeta of Gauss point p.
template <class T>
void addColumns(const V3<T>& a, const V3<T>& b, const V3<T>& c, int p, PointValues<T>& out) {
  V3<T>&x = out.xi[out.ofXi(p)], &e = out.eta[out.ofEta(p)], &z = out.zeta[out.ofZeta(p)];
  x = x + a, e = e + b, z = z + c;
}

}  // namespace stroma::hexahedron
