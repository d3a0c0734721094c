// SPDX-License-Identifier: LGPL-2.1-or-later
// Potentials that exist within one solve: friction with lagged pressures has one. It is used in line searches and is not a stored
// energy.
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

/// The part that is not in the energy() of any field, at the system's x [J].
inline double lentEnergy(const System& system) {
  double sum = 0;
  for (const ForceField* field : system.forceFields())
    if (const LendsEnergy* lender = lenderOf(field)) sum += lender->lentEnergy(system.mappingChain().positions(system.x));
  return sum;
}

}  // namespace stroma
