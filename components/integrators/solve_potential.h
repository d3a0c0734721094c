// SPDX-License-Identifier: LGPL-2.1-or-later
// Potentials that exist within one solve: friction with lagged pressures has one. It is used in line searches and is not a stored
// energy.
#pragma once
#include <algorithm>

#include "framework/mechanics/step_limiter.h"
#include "framework/simulation/system.h"

namespace stroma {

inline const HasSolvePotential* solvePotentialOf(const ForceField* field) {
  const auto* lender = dynamic_cast<const HasSolvePotential*>(field);
  return lender && lender->hasSolvePotential() ? lender : nullptr;
}

/// Whether all forces have a potential within each solve.
inline bool havePotentialInSolves(const System& system) {
  const auto& fields = system.forceFields();
  return std::all_of(fields.begin(), fields.end(), [](const ForceField* f) { return f->traits().conservative || solvePotentialOf(f); });
}

/// The part that is not in the energy() of any field, at the system's x [J].
inline double solvePotential(const System& system) {
  double sum = 0;
  for (const ForceField* field : system.forceFields())
    if (const HasSolvePotential* lender = solvePotentialOf(field)) sum += lender->solvePotential(system.mappingChain().positions(system.x));
  return sum;
}

}  // namespace stroma
