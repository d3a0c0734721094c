// SPDX-License-Identifier: LGPL-2.1-or-later
// Potentials that last for one solve: friction with the pressures of the solve before has one, by which lines are searched, and is
// no energy that a body has.
#pragma once
#include <algorithm>

#include "framework/mechanics/step_limiter.h"
#include "framework/simulation/system.h"

namespace stroma {

inline const LendsEnergy* lenderOf(const ForceField* field) {
  const auto* lender = dynamic_cast<const LendsEnergy*>(field);
  return lender && lender->lendsEnergy() ? lender : nullptr;
}

/// Whether all forces have a potential within each solve.
inline bool haveEnergyInSolves(const System& system) {
  const auto& fields = system.forceFields();
  return std::all_of(fields.begin(), fields.end(), [](const ForceField* f) { return f->traits().conservative || lenderOf(f); });
}

/// What no field's energy() has of it, at the system's x [J].
inline double lentEnergy(const System& system) {
  double sum = 0;
  for (const ForceField* field : system.forceFields())
    if (const LendsEnergy* lender = lenderOf(field)) sum += lender->lentEnergy(system.mappingChain().positions(system.x));
  return sum;
}

}  // namespace stroma
