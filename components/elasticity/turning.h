// SPDX-License-Identifier: LGPL-2.1-or-later
// What the warped tangent of a corotational tetrahedron leaves out: its stress turns with it. With F = V R, strain eps = V - I,
// stress sigma = 2 mu eps + lambda tr(eps) I and a the axial vector of dF R^T, a_x = (dF R^T)_zy - (dF R^T)_yz, the rotation turns by
//   dR = [omega] R,   (tr(V) I - V) omega = a
// In the derivative of P R^T = sigma the symmetric part of [omega] sigma cancels, and what is left is the warped tangent and
//   dP R^T = D sym(dF R^T) + 1/2 [G a],   G = (tr(sigma) I - sigma) (tr(V) I - V)^-1
// G is symmetric, as sigma and V have the same axes, and its numbers are (sigma_i + sigma_j)/(v_i + v_j): tension stiffens against
// turning, pressure softens. With g_i the world gradients, a = sum g_i x dx_i and df_i = 1/2 V_0 g_i x (G a). All of it is
// the exact derivative, at little more than the cost of the warped one.
// Source: Smith, de Goes and Kim 2019 (the eigenvalues of turning); the form above is our own.
#pragma once
#include "components/elasticity/fan_blocks.h"
#include "framework/mechanics/turns_stresses.h"

namespace stroma::tetrahedron {

/// 1/2 G/mu from (mu V_0)^1/2 eps with doubled shear and that root. Where two principal stretches nearly cancel, as in an inverted
/// element at its switching point, turning has no derivative to speak of: none.
template <class T>
S3<T> turningOf(const S3<T>& strain, T root, T ratio) {
  constexpr double least = 0.01;  // of tr(V)^3, of which an element at rest has 8/27
  const T inverse = T(1.) / select(root > T(0.), root, T(1.)), half = T(0.5) * inverse;
  const S3<T> e{strain.xx * inverse, strain.yy * inverse, strain.zz * inverse, strain.xy * half, strain.yz * half, strain.zx * half};
  const T trace = e.xx + e.yy + e.zz, sum = T(2.) + trace, pull = trace + ratio * trace;
  const T xx = sum - e.xx, yy = sum - e.yy, zz = sum - e.zz;  // tr(V) I - V, off its diagonal -e
  const S3<T> c{yy * zz - e.yz * e.yz,         xx * zz - e.zx * e.zx,         xx * yy - e.xy * e.xy,
                e.yz * e.zx + e.xy * zz, e.xy * e.zx + e.yz * xx, e.xy * e.yz + e.zx * yy};
  const T determinant = xx * c.xx - e.xy * c.xy - e.zx * c.zx, size = T(3.) + trace;
  const T factor = select(determinant > T(least) * abs(size * size * size), T(1.) / determinant, T(0.));
  const T sx = pull - e.xx, sy = pull - e.yy, sz = pull - e.zz;  // (tr(sigma) I - sigma)/2 mu, off its diagonal -e
  return S3<T>{sx * c.xx - e.xy * c.xy - e.zx * c.zx, sy * c.yy - e.xy * c.xy - e.yz * c.yz, sz * c.zz - e.zx * c.zx - e.yz * c.yz,
               sx * c.xy - e.xy * c.yy - e.zx * c.yz, sy * c.yz - e.xy * c.zx - e.yz * c.zz, sx * c.zx - e.xy * c.yz - e.zx * c.zz} *
         factor;
}

/// A tangent with 1/2 G/mu times what is to be added of it.
template <class T>
struct TurningTangent {
  Gradients<T> g;
  T ratio;
  S3<T> turning;
};

/// df_i = factor K dx of a tetrahedron with the edges d_i of dx.
template <class T>
void turningProduct(const auto& t, const S3<T>& turning, T factor, const V3<T> (&d)[3], V3<T> (&df)[4]) {
  const S3<T> s = restoringStress(strainOf(d, t.g), factor * t.ratio, factor);
  const V3<T> b = turning * (cross(t.g.g1, d[0]) + cross(t.g.g2, d[1]) + cross(t.g.g3, d[2]));
  df[1] = s * t.g.g1 + cross(t.g.g1, b);
  df[2] = s * t.g.g2 + cross(t.g.g2, b);
  df[3] = s * t.g.g3 + cross(t.g.g3, b);
  df[0] = -(df[1] + df[2] + df[3]);
}

/// K_ab of the warped tangent and 1/2 [g_a] G [g_b].
template <class T>
struct TurningBlocks {
  WarpedBlocks<T> warped;
  V3<T> columns[4][3];  ///< of 1/2 G [g_b]
  TurningBlocks(const auto& rest, const auto& t, const V3<T> (&x)[4]) : warped(rest, t, x) {
    const T zero(0.);
    for (int b = 0; b < 4; ++b) {
      const V3<T>& g = warped.g[b];
      columns[b][0] = t.turning * V3<T>{zero, g.z, -g.y};
      columns[b][1] = t.turning * V3<T>{-g.z, zero, g.x};
      columns[b][2] = t.turning * V3<T>{g.y, -g.x, zero};
    }
  }
  void add(int a, int b, T (&block)[9]) const {
    warped.add(a, b, block);
    for (int k = 0; k < 3; ++k) {
      const V3<T> column = cross(warped.g[a], columns[b][k]);
      block[k] += column.x, block[3 + k] += column.y, block[6 + k] += column.z;
    }
  }
};

}  // namespace stroma::tetrahedron
