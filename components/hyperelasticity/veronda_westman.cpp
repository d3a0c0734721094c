// SPDX-License-Identifier: LGPL-2.1-or-later
// Veronda-Westman: W = c1 (exp(c2 (J^-2/3 I1 - 3)) - 1) - c1 c2/2 (J^-4/3 I2 - 3) + k0/2 (ln J)^2; at small strains
// mu = c1 c2 and the bulk modulus is k0. Infinite at J = 0.
#include "components/hyperelasticity/hyperelastic_kernels.h"

using namespace stroma;
using namespace stroma::hyperelastic;

namespace {

struct VerondaWestman {
  using Set = FirstAndSecond;
  template <class T>
  struct Parameters {
    T c1, c2, k0;
  };
  static auto energy(const auto& J, const auto& I1, const auto& I2, const auto& p) {
    const auto L = log(J);
    const auto isochoric = exp((-2. / 3) * L);
    return p.c1 * (exp(p.c2 * (isochoric * I1 - 3.)) - 1.) - 0.5 * p.c1 * p.c2 * (isochoric * isochoric * I2 - 3.) +
           0.5 * p.k0 * (L * L);
  }
};

/// mu = c1 c2: one of them must be given.
std::string fromLame(const Lame& lame, std::vector<double>& values) {
  if (std::isnan(values[0]) && std::isnan(values[1])) return "VerondaWestman needs c1 or c2 besides youngModulus";
  if (std::isnan(values[0])) values[0] = lame.mu / values[1];
  if (std::isnan(values[1])) values[1] = lame.mu / values[0];
  if (std::isnan(values[2])) values[2] = lame.lambda + 2. / 3 * lame.mu;
  return {};
}

}  // namespace

STROMA_COMPONENT(veronda_westman) {
  HyperelasticLaw law;
  law.name = "VerondaWestman";
  law.formula = "c1 (exp(c2 (J^-2/3 I1 - 3)) - 1) - c1 c2/2 (J^-4/3 I2 - 3) + k0/2 (ln J)^2";
  law.parameters = {{"c1", "Pa", "factor of the exponential", true},
                    {"c2", "-", "factor in the exponent", true},
                    {"k0", "Pa", "bulk modulus", true}};
  law.volume = VolumePart::half_log_squared, law.volume_parameter = 2;
  law.infinite_at_zero = true;
  law.from_lame = fromLame;
  offerHyperelasticLaw(lawOf<VerondaWestman>(law));
}
