// SPDX-License-Identifier: LGPL-2.1-or-later
// A neo-Hookean matrix with one family of fibres that resist stretch alone:
//   W = mu/2 (I1 - 3) - mu ln J + lambda/2 (ln J)^2 + k1/(2 k2) (exp(k2 max(0, J^-2/3 I4 - 1)^2) - 1),   I4 = a C a
// with a the fibre of AnisotropyDirections. Infinite at J = 0. Source of the fibre term: G. A. Holzapfel, T. C. Gasser,
// R. W. Ogden, "A new constitutive framework for arterial wall mechanics and a comparative study of material models",
// Journal of Elasticity 61, 2000.
#include "components/hyperelasticity/hyperelastic_kernels.h"

using namespace stroma;
using namespace stroma::hyperelastic;

namespace {

struct TransverselyIsotropic {
  using Set = FirstAndFibre;
  template <class T>
  struct Parameters {
    T mu, lambda, k1, k2;
  };
  static auto energy(const auto& J, const auto& I1, const auto& I4, const auto& p) {
    const auto L = log(J);
    const auto stretch = squaredPositivePart(exp((-2. / 3) * L) * I4 - 1.);
    return 0.5 * p.mu * (I1 - 3.) + (0.5 * p.lambda * L - p.mu) * L + (0.5 * p.k1 / p.k2) * (exp(p.k2 * stretch) - 1.);
  }
};

}  // namespace

STROMA_COMPONENT(transversely_isotropic) {
  HyperelasticLaw law = inLameConstants(lawOf<TransverselyIsotropic>(
      "TransverselyIsotropic", "NeoHookean + k1/(2 k2) (exp(k2 max(0, J^-2/3 I4 - 1)^2) - 1)",
      {{"k1", "Pa", "stiffness of the fibres", true}, {"k2", "-", "stiffening of the fibres", true}}));
  law.directions = 1;
  law.volume = VolumePart::half_log_squared, law.volume_parameter = 1;
  law.infinite_at_zero = true;
  law.from_lame = [of_matrix = law.from_lame](const Lame& lame, std::vector<double>& values) -> std::string {
    if (std::isnan(values[2]) || std::isnan(values[3]))
      return "TransverselyIsotropic needs k1 and k2 besides youngModulus";
    return of_matrix(lame, values);
  };
  offerHyperelasticLaw(law);
}
