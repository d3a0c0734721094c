// SPDX-License-Identifier: LGPL-2.1-or-later
// St. Venant-Kirchhoff: W = lambda/2 tr(E)^2 + mu tr(E^2), E = (C - Id)/2, which has no J:
//   tr E = (I1 - 3)/2,   tr E^2 = (I1^2 - 2 I2 - 2 I1 + 3)/4
#include "components/hyperelasticity/hyperelastic_kernels.h"

using namespace stroma;
using namespace stroma::hyperelastic;

namespace {

struct StVenantKirchhoff : InLameConstants<FirstAndSecond> {
  static auto energy(const auto&, const auto& I1, const auto& I2, const auto& p) {
    const auto trace = I1 - 3.;
    return 0.125 * p.lambda * (trace * trace) + 0.25 * p.mu * ((I1 * I1 - 2. * I2) - 2. * I1 + 3.);
  }
};

}  // namespace

STROMA_COMPONENT(st_venant_kirchhoff) {
  offerHyperelasticLaw(inLameConstants(lawOf<StVenantKirchhoff>("StVenantKirchhoff", "lambda/2 tr(E)^2 + mu tr(E^2)")));
}
