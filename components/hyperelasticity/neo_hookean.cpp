// SPDX-License-Identifier: LGPL-2.1-or-later
// Neo-Hooke, compressible: W = mu/2 (I1 - 3) - mu ln J + lambda/2 (ln J)^2. Infinite at J = 0.
#include "components/hyperelasticity/hyperelastic_kernels.h"

using namespace stroma;
using namespace stroma::hyperelastic;

namespace {

struct NeoHookean : InLameConstants<First> {
  static auto energy(const auto& J, const auto& I1, const auto& p) {
    const auto L = log(J);
    return 0.5 * p.mu * (I1 - 3.) + (0.5 * p.lambda * L - p.mu) * L;
  }
};

}  // namespace

STROMA_COMPONENT(neo_hookean) {
  HyperelasticLaw law = inLameConstants(lawOf<NeoHookean>("NeoHookean", "mu/2 (I1 - 3) - mu ln J + lambda/2 (ln J)^2"));
  law.volume = VolumePart::half_log_squared, law.volume_parameter = 1;
  law.infinite_at_zero = true;
  offerHyperelasticLaw(law);
}
