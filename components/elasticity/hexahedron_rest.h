// SPDX-License-Identifier: LGPL-2.1-or-later
// What all models of hexahedra share, and the rest shapes that they read.
#pragma once
#include "components/elasticity/hexahedron_law.h"
#include "framework/fem/model_kernels.h"

namespace stroma::hexahedron {

/// What all share: eight nodes in the order of VTK, products that do not read the position unless a model says so.
struct HexahedronModel {
  static constexpr int nodes = 8;
  static constexpr bool reads_position = false;
};

/// Edge lengths in the modes' measure: X_xi = 4 a and so on [m].
template <class T>
struct BoxRest {
  T edges[3];
};
/// The rest shape in its own frame (that of its mean edges; world axes for method small). 840 bytes.
template <class T>
struct PointRest {
  T inverse_edges[6];        ///< [X_xi X_eta X_zeta]^-1, upper triangular (00, 01, 11, 02, 12, 22)
  Modes<T> modes;            ///< X
  Gradients<T> g[8];         ///< w^1/2 / 8 times the rows of J_0^-1
  T scale[8];                ///< of the cofactors of a J made of modes: sign(det J_0) / (512 w^1/2)
  T inverse_determinant[8];  ///< of a J_0 made of modes, 512 det J_0; 0 where B is updated and the volume is not
};

/// R by the mean edges now and at rest where the method asks for them, or by the F that they make.
template <class Rotation, class T>
M3<T> rotationOf(const M3<T>& deformation, const M3<T>& now, const M3<T>& then) {
  if constexpr (requires { Rotation::of(now, then); })
    return Rotation::of(now, then);
  else
    return Rotation::of(deformation);
}

}  // namespace stroma::hexahedron
