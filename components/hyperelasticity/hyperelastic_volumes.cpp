// SPDX-License-Identifier: LGPL-2.1-or-later
// The volumes that a mean dilatation of hexahedra resists (hyperelastic_volume.h). E = k V U(v/V) has the stiffness
//
//   k U''/V dv (x) dv + k U' d2v
//
// with a term for each cell: b = dv, w = k U''/V. The second part is as large as the pressure and stays in the rest of the matrix.
#include "components/hyperelasticity/hyperelastic_force_field.h"
#include "components/hyperelasticity/mean_volume.h"

namespace stroma {
namespace {

using namespace hyperelastic;

double secondDerivative(VolumePart part, double ratio) {
  if (part == VolumePart::half_square) return HalfSquare::at(ratio).second;
  if (part == VolumePart::log_integral) return LogIntegral::at(ratio).second;
  return HalfLogSquared::at(ratio).second;
}

}  // namespace

void HyperelasticForceField::addVolumeTerms(VolumeTerms& terms) const {
  constexpr double worth = 20;  // K / mu; of softer bodies solvers need to know nothing
  if (!mean_dilatation_ || kind->type != CellType::hexahedron) return;
  const double size = 1 / (HexahedronPoints::scale * mesh_->overlap);  // of the sums of CellVolume
  const ConstRows own = state().x();
  const bool is_one = values_.size() == law_.parameters.size();
  HyperelasticLaw::Moduli moduli{};
  for (std::size_t cell = 0; cell < mesh_->hexahedra.size(); ++cell) {
    const auto& corners = mesh_->hexahedra[cell];
    V3<double> rest[8], now[8], gradients[8]{};
    for (std::size_t a = 0; a < 8; ++a) rest[a] = vectorOf(state().rest_position[corners[a]]), now[a] = vectorOf(Vec3(own[corners[a]]));
    const HexahedronVolume<double> at_rest(rest), volume(now);
    volume.gradient(size, gradients);
    const Values values = parameters(cell);
    if (cell == 0 || !is_one) moduli = law_.moduliAtRest(values);
    const double second = secondDerivative(law_.volume, volume.value() / at_rest.value()), held = size * std::abs(at_rest.value());
    if (!(second > 0 && moduli.bulk > worth * moduli.shear)) continue;
    for (std::size_t a = 0; a < 8; ++a) {
      terms.rows.push_back(state().firstRow() + corners[a]);
      terms.gradients.push_back({gradients[a].x, gradients[a].y, gradients[a].z});
    }
    terms.finish(values[law_.volume_parameter] * second / held, moduli.shear / held);
  }
}

}  // namespace stroma
