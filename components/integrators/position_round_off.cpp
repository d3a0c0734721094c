// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cmath>
#include <cstdint>
#include <limits>

#include "components/integrators/newton.h"
#include "framework/mechanics/force_field.h"
#include "framework/mechanics/mass.h"

namespace stroma {

RoundOff positionRoundOff(const System& system, const ForceMeasure& measure, Rows work, Rows product) {
  constexpr double half_unit = std::numeric_limits<double>::epsilon() / 2;
  const ConstRows x = system.independent(system.x);
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  const auto turns = [&](Index row) { return system.motion().kindOf(row) == RowKind::turn; };
  for (Index i = 0; i < x.count; ++i)
    if (!turns(i)) low = low.cwiseMin(x[i]), high = high.cwiseMax(x[i]);
  // an element works with differences over its size, also where a node's own coordinates are small
  const double cell = x.count > 0 ? (high - low).norm() / std::cbrt(double(x.count)) : 0;
  std::uint64_t bits = 0x9e3779b97f4a7c15u;
  clear(work);
  for (Index i = 0; i < x.count; ++i)
    for (int l = 0; l < 3; ++l) {
      bits ^= bits << 13, bits ^= bits >> 7, bits ^= bits << 17;  // xorshift (Marsaglia 2003)
      work[i][l] = (bits & 1 ? half_unit : -half_unit) * (turns(i) ? 1 : std::abs(x[i][l]) + cell);
    }
  system.constraints().project(work);
  clear(product);
  system.addStiffnessProduct(work, {.stiffness = 1}, product);
  system.constraints().project(product);
  const double sums = 4 * std::numeric_limits<double>::epsilon() * measure.force(system.independent(system.f));
  // an energy is a sum of stiffness times volume that nearly cancels where the body is near its rest shape
  const double forces = measure.force(product);
  return {forces + sums, 0.5 * std::abs(dot(work, product)) + cell * forces};
}

double loadsOn(System& system, const ForceMeasure& measure, Rows work) {
  clear(work);
  for (const Mass* mass : system.masses()) mass->addGravity(work);
  for (ForceField* field : system.forceFields())
    if (!field->traits().has_stiffness) field->addForce(system.x, system.v, work);
  return measure.force(work);
}

}  // namespace stroma
