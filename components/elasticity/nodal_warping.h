// SPDX-License-Identifier: LGPL-2.1-or-later
// Warping by node (Mueller et al. 2002), the method that Nesme et al. 2005 (section 2.4) warn of: row i of every
// element's stiffness is turned by the rotation R_i of node i,
//   f_i = -R_i sum_j K_ij (R_i^T x_j - X_j) = -V_0 sigma_i g_i^(i),   g_j^(i) = R_i G_j,  H_i = F R_i^T - I,
// so the rows of one element belong to different frames, do not sum to zero, and leave ghost forces.
#pragma once
#include "components/elasticity/tetrahedron_corotational.h"

namespace stroma::tetrahedron {

/// `g`: rest gradients in world axes; `r[a]`: rotation of node a.
template <class T>
void nodalWarpingForce(const Gradients<T>& g, T lambda, T mu, const V3<T> (&x)[4], const M3<T> (&r)[4], V3<T> (&f)[4]) {
  const V3<T> e[3] = {x[1] - x[0], x[2] - x[0], x[3] - x[0]};
  const M3<T> deformation = outerSum(e, g);
  for (int i = 0; i < 4; ++i) {
    V3<T> forces[4];
    const S3<T> strain = minusIdentity(strainOfProduct(deformation, r[i]));
    nodalForces(restoringStress(strain, lambda, mu), rotated(r[i], g), forces);
    f[i] = forces[i];
  }
}

/// df = -(B^T D B) dx with the gradients g.
template <class T>
void linearProduct(const Gradients<T>& g, T lambda, T mu, const V3<T> (&dx)[4], V3<T> (&df)[4]) {
  const V3<T> d[3] = {dx[1] - dx[0], dx[2] - dx[0], dx[3] - dx[0]};
  nodalForces(restoringStress(strainOf(d, g), lambda, mu), g, df);
}

/// The symmetric part of the warped tangent, df_i = -1/2 sum_j (R_i K_ij R_i^T + R_j K_ij R_j^T) dx_j: the tangent
/// itself is not symmetric, and a conjugate gradient needs it to be.
template <class T>
void nodalWarpingProduct(const Gradients<T>& g, T lambda, T mu, const V3<T> (&dx)[4], const M3<T> (&r)[4],
                         V3<T> (&df)[4]) {
  V3<T> rows[4], columns[4];
  for (int j = 0; j < 4; ++j) {
    const Gradients<T> gj = rotated(r[j], g);
    V3<T> out[4];
    linearProduct(gj, lambda, mu, dx, out);
    rows[j] = out[j];
    V3<T> only[4];
    only[j] = dx[j];
    linearProduct(gj, lambda, mu, only, out);
    for (int i = 0; i < 4; ++i) columns[i] = columns[i] + out[i];
  }
  for (int i = 0; i < 4; ++i) df[i] = (rows[i] + columns[i]) * T(0.5);
}

}  // namespace stroma::tetrahedron
