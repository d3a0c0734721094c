// SPDX-License-Identifier: LGPL-2.1-or-later
// Veronda-Westman: W = c1 (exp(c2 (J^-2/3 I1 - 3)) - 1) - c1 c2/2 (J^-4/3 I2 - 3) + k0/2 (ln J)^2; at small strains
// mu = c1 c2 and the bulk modulus is k0. Infinite at J = 0.
#include "components/hyperelasticity/hyperelastic_kernels.h"

using namespace stroma;
using namespace stroma::hyperelastic;

namespace {

struct VerondaWestman : IsochoricAndBulk<VerondaWestman, FirstAndSecond> {
  template <class T>
  struct Parameters {
    T c1, c2, k0;
  };
  static auto isochoric(const auto& I1, const auto& I2, const auto& p) {
    return p.c1 * (exp(p.c2 * (I1 - 3.)) - 1.) - 0.5 * p.c1 * p.c2 * (I2 - 3.);
  }
};

/// mu = c1 c2: one of them must be given.
std::string fromShear(double mu, std::vector<double>& values) {
  if (std::isnan(values[0]) && std::isnan(values[1])) return "VerondaWestman needs c1 or c2 besides youngModulus";
  if (std::isnan(values[0])) values[0] = mu / values[1];
  if (std::isnan(values[1])) values[1] = mu / values[0];
  return {};
}

}  // namespace

STROMA_COMPONENT(veronda_westman) {
  offerHyperelasticLaw(withBulkModulus(
      lawOf<VerondaWestman>(
          "VerondaWestman", "c1 (exp(c2 (J^-2/3 I1 - 3)) - 1) - c1 c2/2 (J^-4/3 I2 - 3) + k0/2 (ln J)^2",
          {{"c1", "Pa", "factor of the exponential", true}, {"c2", "-", "factor in the exponent", true}}),
      fromShear));
}
