// SPDX-License-Identifier: LGPL-2.1-or-later
// The stiffness of a hexahedron that is a box at rest, by its modes.
#pragma once
#include "components/elasticity/hexahedron_law.h"

namespace stroma::hexahedron {

// ---- boxes: a = diag(i, j, k) is the same at all Gauss points, and modes separate ----
// H is a sum of 1, xi, eta, zeta, xi eta, eta zeta, zeta xi with a coefficient each, whose squares integrate to 1, 1/3
// and 1/9: K falls apart in one full strain, three strains of two columns and a diagonal.

/// The axes renamed x <- y <- z <- x, and back: one routine for two columns serves all three pairs.
template <class T>
V3<T> cycled(const V3<T>& v) {
  return {v.y, v.z, v.x};
}
template <class T>
V3<T> cycledBack(const V3<T>& v) {
  return {v.z, v.x, v.y};
}

/// -K of the strain that is the same all over the box; the other modes are zero.
template <class T>
Modes<T> uniformProduct(const T (&inverse)[3], T lambda, T mu, const Modes<T>& m) {
  const T i = inverse[0], j = inverse[1], k = inverse[2];
  const S3<T> strain{m.xi.x * i,
                     m.eta.y * j,
                     m.zeta.z * k,
                     fma(m.xi.y, i, m.eta.x * j),
                     fma(m.eta.z, j, m.zeta.y * k),
                     fma(m.zeta.x, k, m.xi.z * i)};
  const S3<T> s = restoringStress(strain, lambda, mu);
  Modes<T> f{};
  f.xi = V3<T>{s.xx, s.xy, s.zx} * i, f.eta = V3<T>{s.xy, s.yy, s.yz} * j, f.zeta = V3<T>{s.zx, s.yz, s.zz} * k;
  return f;
}
/// -K of the mode xi eta zeta, with `direct` = mu and what resists its change of volume.
template <class T>
V3<T> productOfAll(const T (&inverse)[3], T direct, T mu, const V3<T>& all) {
  const T ii = inverse[0] * inverse[0], jj = inverse[1] * inverse[1], kk = inverse[2] * inverse[2], minus_ninth(-1. / 9);
  const T shear = mu * (ii + jj + kk);
  return {minus_ninth * fma(direct, ii, shear) * all.x, minus_ninth * fma(direct, jj, shear) * all.y,
          minus_ninth * fma(direct, kk, shear) * all.z};
}

/// H = [a i, b j, 0]: adds -sigma_x i to fa and -sigma_y j to fb.
template <class T>
void addTwoColumns(const V3<T>& a, const V3<T>& b, T i, T j, T lambda, T mu, V3<T>& fa, V3<T>& fb) {
  const T minus_mu = -mu, xx = a.x * i, yy = b.y * j, two_mu = minus_mu + minus_mu;
  const T pressure = lambda * (xx + yy), shear = minus_mu * fma(a.y, i, b.x * j);
  const T xz = minus_mu * (a.z * i), yz = minus_mu * (b.z * j);
  const V3<T> sx{fma(two_mu, xx, -pressure), shear, xz}, sy{shear, fma(two_mu, yy, -pressure), yz};
  fa = fma(i, sx, fa), fb = fma(j, sy, fb);
}

/// What a box needs: inverse = (i, j, k) = 2 / edge lengths [1/m]; Lame's constants times w/8. `varying` is lambda for
/// the part of the volume change that varies over the box and has no mean: lambda, or -2/3 mu with the mean dilatation.
template <class T>
struct BoxStiffness {
  T inverse[3], lambda, varying, mu;
};

/// -factor K of a box's modes in its own axes.
template <class T>
Modes<T> boxProduct(const BoxStiffness<T>& box, T factor, const Modes<T>& m) {
  const T i = box.inverse[0], j = box.inverse[1], k = box.inverse[2];
  const T varying = factor * box.varying, mu = factor * box.mu, third(1. / 3), lambda3 = varying * third, mu3 = mu * third;
  Modes<T> f = uniformProduct(box.inverse, factor * box.lambda, mu, m);
  // zeta: columns x, y; xi: columns y, z; eta: columns z, x
  addTwoColumns(m.zeta_xi, m.eta_zeta, i, j, lambda3, mu3, f.zeta_xi, f.eta_zeta);
  V3<T> fa, fb;
  addTwoColumns(cycled(m.xi_eta), cycled(m.zeta_xi), j, k, lambda3, mu3, fa, fb);
  f.xi_eta = f.xi_eta + cycledBack(fa), f.zeta_xi = f.zeta_xi + cycledBack(fb);
  V3<T> fc, fd;
  addTwoColumns(cycledBack(m.eta_zeta), cycledBack(m.xi_eta), k, i, lambda3, mu3, fc, fd);
  f.eta_zeta = f.eta_zeta + cycled(fc), f.xi_eta = f.xi_eta + cycled(fd);
  f.all = productOfAll(box.inverse, varying + mu, mu, m.all);
  return f;
}

// ---- with incompatible modes ----
// Of what varies along xi, the modes a_xi take all strain with an x in it until no stress is left there, so that a plane yz bends as
// if it were free.

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
struct IncompatibleBoxStiffness {
  T inverse[3], lambda, plane, varying, mu;
};
/// -factor K of a box's modes in its own axes.
template <class T>
Modes<T> boxProduct(const IncompatibleBoxStiffness<T>& box, T factor, const Modes<T>& m) {
  const T i = box.inverse[0], j = box.inverse[1], k = box.inverse[2], third(1. / 3);
  const T mu = factor * box.mu, plane3 = factor * box.plane * third, mu3 = mu * third;
  Modes<T> f = uniformProduct(box.inverse, factor * box.lambda, mu, m);
  // along xi: columns y, z; eta: columns z, x; zeta: columns x, y
  addPlane(m.xi_eta, m.zeta_xi, j, k, plane3, mu3, f.xi_eta, f.zeta_xi);
  V3<T> fa{}, fb{}, fc{}, fd{};
  addPlane(cycled(m.eta_zeta), cycled(m.xi_eta), k, i, plane3, mu3, fa, fb);
  addPlane(cycledBack(m.zeta_xi), cycledBack(m.eta_zeta), i, j, plane3, mu3, fc, fd);
  f.xi_eta = f.xi_eta + cycledBack(fb), f.zeta_xi = f.zeta_xi + cycled(fc), f.eta_zeta = cycledBack(fa) + cycled(fd);
  f.all = productOfAll(box.inverse, fma(factor, box.varying, mu), mu, m.all);
  return f;
}

/// The diagonal blocks of K, [node][row][column], of a box with these axes: boxProduct() of a node that moves alone. With
/// a, b, c the axes times i, j, k and s the signs of a corner,
///   K_n = -(lambda + 7/9 varying + 16/9 mu) (a a^T + b b^T + c c^T) - 16/9 mu (a.a + b.b + c.c)
///         - (lambda + varying / 3 + 4/3 mu) (s_x s_y (a b^T + b a^T) + ...),
/// and the last sum is g g^T - a a^T - b b^T - c c^T, g = s_x a + s_y b + s_z c.
template <class T>
void boxDiagonal(const BoxStiffness<T>& box, const M3<T>& axes, T (&k)[8 * 9]) {
  const T i = box.inverse[0], j = box.inverse[1], l = box.inverse[2];
  const V3<T> a = axes.c0 * i, b = axes.c1 * j, c = axes.c2 * l, sides[4] = {a + b + c, b + c - a, a + b - c, a - b + c};
  const T shear = T(-16. / 9) * box.mu, rest = shear * (i * i + j * j + l * l);
  const T mixed = -fma(T(4. / 3), box.mu, fma(T(1. / 3), box.varying, box.lambda));
  const T along = shear - mixed - fma(T(7. / 9), box.varying, box.lambda);
  const auto addSquare = [](T factor, const V3<T>& v, T(&to)[6]) {
    const V3<T> left = v * factor;
    to[0] = fma(left.x, v.x, to[0]), to[1] = fma(left.x, v.y, to[1]), to[2] = fma(left.x, v.z, to[2]);
    to[3] = fma(left.y, v.y, to[3]), to[4] = fma(left.y, v.z, to[4]), to[5] = fma(left.z, v.z, to[5]);
  };
  const T none(0.);
  T same[6] = {rest, none, none, rest, none, rest};
  for (const V3<T>& side : {a, b, c}) addSquare(along, side, same);
  for (int n = 0; n < 4; ++n) {
    T own[6] = {same[0], same[1], same[2], same[3], same[4], same[5]};
    addSquare(mixed, sides[n], own);
    for (T* out : {k + 9 * n, k + 9 * ((n + 2) % 4 + 4)}) {  // this corner and the one across
      out[0] = own[0], out[1] = out[3] = own[1], out[2] = out[6] = own[2];
      out[4] = own[3], out[5] = out[7] = own[4], out[8] = own[5];
    }
  }
}

}  // namespace stroma::hexahedron
