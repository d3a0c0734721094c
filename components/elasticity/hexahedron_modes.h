// SPDX-License-Identifier: LGPL-2.1-or-later
// Modes of a hexahedron that turn with it, and stresses at its Gauss points (framework/fem/hexahedron.h). R = rotation of F of
// the mean edges: F_mean = [u_xi u_eta u_zeta] [X_xi X_eta X_zeta]^-1. In all variants
//   H = sum_i (J - R J_0)_i (x) g_i over the columns i, eps = sym H, sigma = lambda tr(eps) I + 2 mu eps,
// and the force is -sum over Gauss points of w sigma g (the same B gives strain and force), with
//   B not updated:   g = R a
//   B updated:       g_i = n_i / det J_0, n_i the columns of the cofactor matrix of J
//   B and V updated: g_i = n_i / det J, and the weight |det J|
// Source: M. Nesme et al. 2005, sections 2, 3 and 5.1 and appendix A.
#pragma once
#include "components/elasticity/strain.h"
#include "framework/fem/hexahedron.h"

namespace stroma::hexahedron {

/// Calls f(mode of a, mode of b) for each of the seven.
template <class A, class B, class F>
void forEachMode(A& a, B& b, F&& f) {
  f(a.xi, b.xi), f(a.eta, b.eta), f(a.zeta, b.zeta), f(a.xi_eta, b.xi_eta), f(a.eta_zeta, b.eta_zeta),
      f(a.zeta_xi, b.zeta_xi), f(a.all, b.all);
}

/// R m
template <class T>
Modes<T> rotated(const M3<T>& r, const Modes<T>& m) {
  Modes<T> out;
  forEachMode(out, m, [&](V3<T>& a, const V3<T>& b) { a = r * b; });
  return out;
}
/// R^T m
template <class T>
Modes<T> rotatedBack(const M3<T>& r, const Modes<T>& m) {
  Modes<T> out;
  forEachMode(out, m, [&](V3<T>& a, const V3<T>& b) { a = transposedTimes(r, b); });
  return out;
}
template <class T>
Modes<T> operator-(const Modes<T>& a, const Modes<T>& b) {
  Modes<T> out = a;
  forEachMode(out, b, [](V3<T>& c, const V3<T>& d) { c = c - d; });
  return out;
}
template <class T>
Modes<T> operator+(const Modes<T>& a, const Modes<T>& b) {
  Modes<T> out = a;
  forEachMode(out, b, [](V3<T>& c, const V3<T>& d) { c = c + d; });
  return out;
}
template <class T>
T dot(const Modes<T>& a, const Modes<T>& b) {
  T sum(0.);
  forEachMode(a, b, [&](const V3<T>& c, const V3<T>& d) { sum += stroma::dot(c, d); });
  return sum;
}
/// 8 [u_xi u_eta u_zeta]: what the rotation of an element is taken from.
template <class T>
M3<T> meanEdges(const Modes<T>& m) {
  return {m.xi, m.eta, m.zeta};
}

/// Adds s g_i at Gauss point p.
template <class T>
void addStress(const S3<T>& s, const Gradients<T>& g, int p, PointValues<T>& out) {
  addColumns(s * g.g1, s * g.g2, s * g.g3, p, out);
}

}  // namespace stroma::hexahedron
