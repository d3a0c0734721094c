// SPDX-License-Identifier: LGPL-2.1-or-later
// Neo-Hooke without a logarithm: W = mu/2 (I1 - 3) + (lambda + mu)/2 ((J - a)^2 - (1 - a)^2), a = 1 + mu/(lambda + mu),
// so that the rest shape has neither stress nor energy. Finite for every J. Source: B. Smith, F. de Goes, T. Kim,
// "Stable neo-Hookean flesh simulation", ACM Transactions on Graphics 37(2), 2018, without its barrier term.
#include "components/hyperelasticity/hyperelastic_kernels.h"

using namespace stroma;
using namespace stroma::hyperelastic;

namespace {

struct StableNeoHookean : InLameConstants<First> {
  // (lambda + mu)/2 ((J - a)^2 - (1 - a)^2) = (J - 1) ((lambda + mu)/2 (J - 1) - mu)
  static auto energy(const auto& J, const auto& I1, const auto& p) {
    const auto change = J - 1.;
    return 0.5 * p.mu * (I1 - 3.) + change * (0.5 * (p.lambda + p.mu) * change - p.mu);
  }
};

}  // namespace

STROMA_COMPONENT(stable_neo_hookean) {
  HyperelasticLaw law = inLameConstants(lawOf<StableNeoHookean>(
      "StableNeoHookean", "mu/2 (I1 - 3) + (lambda + mu)/2 ((J - a)^2 - (1 - a)^2), a = 1 + mu/(lambda + mu)"));
  law.volume = VolumePart::half_square, law.volume_parameter = 1;
  offerHyperelasticLaw(law);
}
