// SPDX-License-Identifier: LGPL-2.1-or-later
// Mooney-Rivlin: W = c1 (J^-2/3 I1 - 3) + c2 (J^-4/3 I2 - 3) + k0/2 (ln J)^2; at small strains mu = 2 (c1 + c2) and the
// bulk modulus is k0. Infinite at J = 0.
#include <fmt/format.h>

#include "components/hyperelasticity/hyperelastic_kernels.h"

using namespace stroma;
using namespace stroma::hyperelastic;

namespace {

struct MooneyRivlin : IsochoricAndBulk<MooneyRivlin, FirstAndSecond> {
  template <class T>
  struct Parameters {
    T c1, c2, k0;
  };
  static auto isochoric(const auto& I1, const auto& I2, const auto& p) { return p.c1 * (I1 - 3.) + p.c2 * (I2 - 3.); }
};

/// mu = 2 (c1 + c2): one of them must be given, and must leave the other its part.
std::string fromShear(double mu, std::vector<double>& values) {
  const double sum = mu / 2;
  if (std::isnan(values[0]) && std::isnan(values[1])) return "MooneyRivlin needs c1 or c2 besides youngModulus";
  for (int given : {0, 1})
    if (std::isnan(values[1 - given])) {
      const double other = values[1 - given] = sum - values[given];
      if (other < 0)
        return fmt::format("c{} = {:g} of MooneyRivlin is above mu/2 = {:g} of youngModulus: c{} would be negative",
                           given + 1, values[given], sum, 2 - given);
    }
  return {};
}

}  // namespace

STROMA_COMPONENT(mooney_rivlin) {
  HyperelasticLaw law = withBulkModulus(
      lawOf<MooneyRivlin>(
          "MooneyRivlin", "c1 (J^-2/3 I1 - 3) + c2 (J^-4/3 I2 - 3) + k0/2 (ln J)^2",
          {{"c1", "Pa", "factor of the first invariant"}, {"c2", "Pa", "factor of the second invariant"}}),
      fromShear);
  law.check = [](Values p) {
    return p[0] + p[1] > 0 ? "" : "c1 + c2 of MooneyRivlin is not above 0: the shear modulus is twice that";
  };
  offerHyperelasticLaw(law);
}
