// SPDX-License-Identifier: LGPL-2.1-or-later
// The stiffness matrix of an element of N nodes and P points, block by block: sums over the points stay in registers,
// and only the pairs a <= b are computed. With n_a the gradient of node a's shape function (times the root of the
// point's weight),
//   K_ab = -sum_p [ lambda n_a (x) n_b + mu n_b (x) n_a + mu (n_a . n_b) I ]
//   K_ab = -sum_p [ lambda m_a (x) m_b + mu m_b (x) m_a + mu (n_a . n_b) F F^T + (n_a . S n_b) I ],   m_a = F n_a
// for small strains and for St. Venant-Kirchhoff.
#pragma once
#include "components/elasticity/strain.h"
#include "framework/fem/rotation.h"

namespace stroma::elastic {

/// n_a of each node and point.
template <int N, int P, class T>
using NodeGradients = V3<T>[N][P];

/// Adds a (x) b, row-major. Written out: of loops the compiler stores the numbers of a and b each time.
template <class T>
void addOuter(const V3<T>& a, const V3<T>& b, T (&block)[9]) {
  block[0] = fma(a.x, b.x, block[0]), block[1] = fma(a.x, b.y, block[1]), block[2] = fma(a.x, b.z, block[2]);
  block[3] = fma(a.y, b.x, block[3]), block[4] = fma(a.y, b.y, block[4]), block[5] = fma(a.y, b.z, block[5]);
  block[6] = fma(a.z, b.x, block[6]), block[7] = fma(a.z, b.y, block[7]), block[8] = fma(a.z, b.z, block[8]);
}
/// Adds s a (x) b.
template <class T>
void addOuter(T s, const V3<T>& a, const V3<T>& b, T (&block)[9]) {
  addOuter(a * s, b, block);
}

/// What the turning of rotations adds to the matrix, K_ab += sum_q forces[a][q] (x) spins[b][q]: spins[b] are the derivatives of
/// the angles omega_q of dR = R [omega]x by the place of node b, forces[a] those of its force by the angles.
template <int N, int Q, class T>
void addTurning(const V3<T> (&forces)[N][Q], const V3<T> (&spins)[N][Q], T (&k)[N * N * 9]) {
  for (int a = 0; a + 1 < N; a += 2)  // two at once read the spins half as often, which do not stay in the first cache beside K
    for (int b = 0; b < N; ++b) {
      T first[9], second[9];
      T *const to = k + (a * N + b) * 9, *const next = to + N * 9;
      for (int i = 0; i < 9; ++i) first[i] = to[i], second[i] = next[i];
      for (int q = 0; q < Q; ++q) {
        const V3<T> spin = spins[b][q];
        addOuter(forces[a][q], spin, first), addOuter(forces[a + 1][q], spin, second);
      }
      for (int i = 0; i < 9; ++i) to[i] = first[i], next[i] = second[i];
    }
  for (int b = 0; N % 2 && b < N; ++b) {
    T last[9];
    T* const to = k + ((N - 1) * N + b) * 9;
    for (int i = 0; i < 9; ++i) last[i] = to[i];
    for (int q = 0; q < Q; ++q) addOuter(forces[N - 1][q], spins[b][q], last);
    for (int i = 0; i < 9; ++i) to[i] = last[i];
  }
}
/// Derivatives of the three angles by v, where F changes by v (x) g: one for each angle, in `spin`.
template <class Rotation, class T>
void spinsAlong(const M3<T>& f, const M3<T>& r, const V3<T>& g, V3<T> (&spin)[3]) {
  const T zero(0.);
  const auto omega = [&](const M3<T>& df) {
    const M3<T> dr = Rotation::differential(f, r, df);
    return V3<T>{stroma::dot(r.c2, dr.c1), stroma::dot(r.c0, dr.c2), stroma::dot(r.c1, dr.c0)};
  };
  const V3<T> x = omega({{g.x, zero, zero}, {g.y, zero, zero}, {g.z, zero, zero}}),
              y = omega({{zero, g.x, zero}, {zero, g.y, zero}, {zero, g.z, zero}}),
              z = omega({{zero, zero, g.x}, {zero, zero, g.y}, {zero, zero, g.z}});
  spin[0] = {x.x, y.x, z.x}, spin[1] = {x.y, y.y, z.y}, spin[2] = {x.z, y.z, z.z};
}
/// R [e_m]x
template <class T>
M3<T> turnedAbout(const M3<T>& r, int m) {
  const T one(1.), zero(0.);
  return rotation::timesCross(r, V3<T>{m == 0 ? one : zero, m == 1 ? one : zero, m == 2 ? one : zero});
}

/// k[a][b][row][column] from add(a, b, block), which adds K_ab for a <= b to zeros.
template <int N, class T, class AddBlock>
void fillSymmetric(T (&k)[N * N * 9], AddBlock&& add) {
  for (int a = 0; a < N; ++a)
    for (int b = a; b < N; ++b) {
      T block[9] = {T(0.), T(0.), T(0.), T(0.), T(0.), T(0.), T(0.), T(0.), T(0.)};
      add(a, b, block);
      T *upper = k + (a * N + b) * 9, *lower = k + (b * N + a) * 9;
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) upper[3 * r + c] = lower[3 * c + r] = block[3 * r + c];
    }
}

/// K of small strains.
template <int N, int P, class T>
void smallStrainMatrix(const V3<T> (&n)[N][P], T lambda, T mu, T (&k)[N * N * 9]) {
  const T minus_lambda = -lambda, minus_mu = -mu;
  fillSymmetric<N>(k, [&](int a, int b, T(&block)[9]) {
    T shear(0.);
    for (int p = 0; p < P; ++p) {
      addOuter(minus_lambda, n[a][p], n[b][p], block);
      addOuter(minus_mu, n[b][p], n[a][p], block);
      shear = fma(minus_mu, stroma::dot(n[a][p], n[b][p]), shear);
    }
    block[0] += shear, block[4] += shear, block[8] += shear;
  });
}

/// K -= bulk n_a (x) n_b: the part of a mean dilatation whose derivative at node a is n_a.
template <int N, class T>
void addSquare(const V3<T> (&n)[N], T bulk, T (&k)[N * N * 9]) {
  for (int a = 0; a < N; ++a)
    for (int b = 0; b < N; ++b) {
      const T left[3] = {-bulk * n[a].x, -bulk * n[a].y, -bulk * n[a].z}, right[3] = {n[b].x, n[b].y, n[b].z};
      T* block = k + (a * N + b) * 9;
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) block[3 * r + c] = fma(left[r], right[c], block[3 * r + c]);
    }
}

/// A point of St. Venant-Kirchhoff: F with the root of its weight w, -S, and 1/w.
template <class T>
struct GreenState {
  M3<T> f;
  S3<T> minus_s;
  T inverse_weight;
};

/// K of St. Venant-Kirchhoff.
template <int N, int P, class T>
void greenStrainMatrix(const V3<T> (&n)[N][P], const GreenState<T> (&state)[P], T lambda, T mu, T (&k)[N * N * 9]) {
  V3<T> m[N][P];
  S3<T> left_cauchy_green[P];
  for (int p = 0; p < P; ++p) {
    const M3<T> f = transpose(state[p].f);  // columns: rows of F
    left_cauchy_green[p] = {stroma::dot(f.c0, f.c0), stroma::dot(f.c1, f.c1), stroma::dot(f.c2, f.c2),
                            stroma::dot(f.c0, f.c1), stroma::dot(f.c1, f.c2), stroma::dot(f.c2, f.c0)};
    for (int a = 0; a < N; ++a) m[a][p] = state[p].f * n[a][p];
  }
  fillSymmetric<N>(k, [&](int a, int b, T(&block)[9]) {
    T geometric(0.);
    S3<T> sum;
    for (int p = 0; p < P; ++p) {
      const T minus_mu = -mu * state[p].inverse_weight;
      addOuter(-lambda * state[p].inverse_weight, m[a][p], m[b][p], block);
      addOuter(minus_mu, m[b][p], m[a][p], block);
      geometric += stroma::dot(n[a][p], state[p].minus_s * n[b][p]);
      const T s = minus_mu * stroma::dot(n[a][p], n[b][p]);
      const S3<T>& c = left_cauchy_green[p];
      sum = {fma(s, c.xx, sum.xx), fma(s, c.yy, sum.yy), fma(s, c.zz, sum.zz),
             fma(s, c.xy, sum.xy), fma(s, c.yz, sum.yz), fma(s, c.zx, sum.zx)};
    }
    const T symmetric[9] = {sum.xx + geometric, sum.xy, sum.zx, sum.xy, sum.yy + geometric, sum.yz, sum.zx, sum.yz,
                            sum.zz + geometric};
    for (int i = 0; i < 9; ++i) block[i] += symmetric[i];
  });
}

}  // namespace stroma::elastic
