// SPDX-License-Identifier: LGPL-2.1-or-later
// Costa's orthotropic exponential: W = a/2 (exp(J^-4/3 Q) - 1) + k0 (J ln J - J + 1),
//   Q = bff Eff^2 + bss Ess^2 + bnn Enn^2 + 2 bfs Efs^2 + 2 bfn Efn^2 + 2 bsn Esn^2
// with E = (C - Id)/2 in the axes fibre, sheet, normal of AnisotropyDirections. J^-4/3 Q(E) is not Q of the isochoric
// strain (a pure dilation has one); it is what the method uses, and identical at J = 1. With bff = bf, bss = bnn = bsn
// = bt, bfs = bfn = bfs it is Guccione's law. The energy is finite down to J = 0, where its Q is not.
#include "components/hyperelasticity/hyperelastic_kernels.h"

using namespace stroma;
using namespace stroma::hyperelastic;

namespace {

struct Costa {
  using Set = Quadratic;
  template <class T>
  struct Parameters {
    T a, k0, bff, bfs, bss, bfn, bsn, bnn;
  };
  static auto energy(const auto& J, const auto& Q, const auto& p) {
    const auto L = log(J);
    return 0.5 * p.a * (exp(exp((-4. / 3) * L) * Q) - 1.) + p.k0 * (J * (L - 1.) + 1.);
  }
};

}  // namespace

STROMA_COMPONENT(costa) {
  HyperelasticLaw law =
      lawOf<Costa>("Costa", "a/2 (exp(J^-4/3 Q) - 1) + k0 (J ln J - J + 1), Q = sum b_ij E_ij^2 in fibre axes",
                   {{"a", "Pa", "factor of the exponential", true},
                    {"k0", "Pa", "bulk modulus of the volumetric part", true},
                    {"bff", "-", "stiffness along the fibre", true},
                    {"bfs", "-", "of shear between fibre and sheet", true},
                    {"bss", "-", "along the sheet", true},
                    {"bfn", "-", "of shear between fibre and normal", true},
                    {"bsn", "-", "of shear between sheet and normal", true},
                    {"bnn", "-", "along the normal", true}});
  law.directions = 3;
  law.volume = VolumePart::log_integral, law.volume_parameter = 1;
  law.infinite_at_zero = true;
  offerHyperelasticLaw(law);
}
