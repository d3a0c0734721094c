// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/fem/pack.h"

namespace stroma::porous {

using std::log;

/// The laws of a sponge: sigma_H(J), its slope and its integral, and ln J with its slope, all with the tangent below
/// J_0; and how its fluid pushes. TetrahedronPorousForceField's page has the formulas.
struct Sponge {
  double fluid = 0.5, bulk = 400, limit = 2200;  ///< f_w, K_0 [Pa], K_lim [Pa]
  double coefficient = 1;                        ///< Biot's alpha
  double modulus = 2200;                         ///< Biot's M [Pa]: the fluid's storage is 1/M

  double bound() const { return 1 - fluid + bulk / limit; }  ///< J_0
  /// Of a volume that keeps its fluid, per ln J [Pa].
  double undrainedStiffening() const { return coefficient * coefficient * modulus; }
  template <class T>
  T stress(T j) const {
    const T at = maximum(j, T(bound()));
    return T(bulk * fluid) * log((at + T(fluid - 1)) * T(1 / fluid)) + T(fluid * limit) * (j - at);
  }
  template <class T>
  T slope(T j) const {
    return T(bulk * fluid) / (maximum(j, T(bound())) + T(fluid - 1));
  }
  template <class T>
  T energy(T j) const {
    const T at = maximum(j, T(bound())), u = at + T(fluid - 1), below = j - at;
    const T whole = T(bulk * fluid) * (u * log(u * T(1 / fluid)) - u + T(fluid));
    return whole + below * (stress(at) + T(0.5 * fluid * limit) * below);
  }
  template <class T>
  T logarithm(T j) const {
    const T at = maximum(j, T(bound()));
    return log(at) + (j - at) / at;
  }
  template <class T>
  T logarithmSlope(T j) const {
    return T(1.) / maximum(j, T(bound()));
  }
};

}  // namespace stroma::porous
