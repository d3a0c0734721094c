// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

namespace stroma {

/// Lame's constants [Pa] from Young's modulus E [Pa] and Poisson's ratio nu < 1/2.
struct Lame {
  double lambda, mu;  ///< mu is the shear modulus
  double bulk() const { return lambda + 2. / 3 * mu; }
  static Lame from(double young_modulus, double poisson_ratio) {
    return {young_modulus * poisson_ratio / ((1 + poisson_ratio) * (1 - 2 * poisson_ratio)),
            young_modulus / (2 * (1 + poisson_ratio))};
  }
};

}  // namespace stroma
