// SPDX-License-Identifier: LGPL-2.1-or-later
// The rotation R of an element from its deformation gradient F, one struct a method, each with
//   R = of(F)                          always orthonormal and right-handed, for |F| up to 1e150
//   dR = differential(F, R, dF)        the derivative of R in the direction dF
// Source: Nesme et al. 2005, sections 2.4, 3.2 and 5.1. T is a Pack or a double.
#pragma once
#include "framework/fem/rotation.h"

namespace stroma::rotation {

/// omega of dQ = Q [omega]x for Q = orthogonalFactor(F): (tr(S) I - S) omega = axial(Q^T dF - dF^T Q), S = Q^T F.
template <class T>
V3<T> polarSpin(const M3<T>& q, const M3<T>& f, const M3<T>& df) {
  const S3<T> s = stretch(q, f);
  const M3<T> w = transposedTimes(q, df);
  const V3<T> axial{w.c1.z - w.c2.y, w.c2.x - w.c0.z, w.c0.y - w.c1.x};
  const M3<T> g{{s.yy + s.zz, -s.xy, -s.zx}, {-s.xy, s.zz + s.xx, -s.yz}, {-s.zx, -s.yz, s.xx + s.yy}};
  const M3<T> c = cofactor(g);
  T determinant = dot(g.c0, c.c0);
  // two opposite singular values (an inverted element at its switching point): the rotation has no derivative there
  const T floor = T(1e-9) * sqrt(squaredNorm(c)) * sqrt(squaredNorm(g)) + T(1e-300);
  determinant = select(abs(determinant) < floor, select(determinant < T(0.), -floor, floor), determinant);
  return (c * axial) * (T(1.) / determinant);  // g is symmetric, so its cofactor matrix is its adjugate
}

/// method = large: the frame of the first edge and of the plane of the first two (QR). F's columns are combinations of
/// the edges a-b; a-b, a-c; ... with positive factors on the diagonal, so the frame of the columns is that of the
/// edges. An inversion is always seen as one of the fourth vertex: the frame stays right-handed at no cost.
struct Qr {
  template <class T>
  static M3<T> of(const M3<T>& f) {
    return gramSchmidt(f);
  }
  /// With F = R U, U upper triangular: the strict lower part of R^T dF U^-1 is that of the spin R^T dR.
  template <class T>
  static M3<T> differential(const M3<T>& f, const M3<T>& r, const M3<T>& df) {
    const T u00 = dot(r.c0, f.c0), u01 = dot(r.c0, f.c1), u11 = dot(r.c1, f.c1);
    const T tiny(1e-12);
    const T i00 = T(1.) / maximum(u00, tiny), i11 = T(1.) / maximum(u11, tiny);
    const T m10 = dot(r.c1, df.c0) * i00, m20 = dot(r.c2, df.c0) * i00;
    const T m21 = (dot(r.c2, df.c1) - u01 * m20) * i11;
    return timesCross(r, V3<T>{m21, -m20, m10});
  }
};

/// method = polar: the nearest orthogonal matrix; where it is a reflection (det F < 0) the axis of the rest frame that
/// is stretched least is flipped, so that the element does not settle in its mirror image. R^T F is then not symmetric:
/// the force of an inverted element has no potential.
struct Polar {
  template <class T>
  static M3<T> of(const M3<T>& f) {
    const M3<T> q = orthogonalFactor(f);
    const auto reflected = dot(q.c0, cross(q.c1, q.c2)) < T(0.);
    return any(reflected) ? select(reflected, flipLeastStretched(q, f), q) : q;
  }
  template <class T>
  static M3<T> differential(const M3<T>& f, const M3<T>& r, const M3<T>& df) {
    const T determinant = dot(f.c0, cross(f.c1, f.c2));
    const auto reflected = determinant < T(0.);
    if (!any(reflected)) return timesCross(r, polarSpin(r, f, df));
    // R = Q D with D a diagonal of signs: find D again and differentiate Q
    const M3<T> q = select(reflected, orthogonalFactor(f), r);
    const M3<T> dq = timesCross(q, polarSpin(q, f, df));
    const T one(1.);
    const auto sign = [&](const V3<T>& a, const V3<T>& b) { return select(dot(a, b) < T(0.), -one, one); };
    return {dq.c0 * sign(q.c0, r.c0), dq.c1 * sign(q.c1, r.c1), dq.c2 * sign(q.c2, r.c2)};
  }

 private:
  template <class T>
  static M3<T> flipLeastStretched(const M3<T>& q, const M3<T>& f) {
    const T s0 = dot(q.c0, f.c0), s1 = dot(q.c1, f.c1), s2 = dot(q.c2, f.c2);
    const auto first = s0 < s1 && s0 < s2;
    const auto second = !first && s1 < s2;
    const auto third = !(first || second);
    return {select(first, -q.c0, q.c0), select(second, -q.c1, q.c1), select(third, -q.c2, q.c2)};
  }
};

/// method = svd: the nearest rotation for every F.
struct Svd {
  template <class T>
  static M3<T> of(const M3<T>& f) {
    return nearest(f);
  }
  /// R^T F is symmetric for det F < 0 too, so the formula of the polar factor holds as it is.
  template <class T>
  static M3<T> differential(const M3<T>& f, const M3<T>& r, const M3<T>& df) {
    return timesCross(r, polarSpin(r, f, df));
  }
};

}  // namespace stroma::rotation
