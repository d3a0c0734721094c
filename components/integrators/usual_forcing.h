// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>

#include "components/integrators/newton.h"
#include "framework/algebra/solver_choice.h"
#include "framework/simulation/integrator.h"
#include "framework/simulation/system.h"

namespace stroma {

/// One solve is then the solution, which nothing loose may take the place of.
inline bool hasLinearForces(const System& system) {
  const auto& fields = system.forceFields();
  return std::all_of(fields.begin(), fields.end(), [](const ForceField* field) { return field->traits().linear; });
}

/// The forcing term of statics whose scene writes none: with a linear solver that chooses its method, which does so here,
/// early solves are loose, unless forces are affine in x. 0 with solvers that a scene names: their tolerance is theirs.
inline void takeUsualForcing(System& system, NewtonSettings& settings) {
  auto* choosing = dynamic_cast<SolverChoice*>(system.linearSolver());
  if (choosing) choosing->choose(system.matrix());
  settings.is_linear = choosing && hasLinearForces(system);
  settings.forcing = choosing && !settings.is_linear ? 0.1 : 0;
}

/// That of steps in time by Newton's method: likewise, where the linear solver was made because the scene has none.
inline double usualForcingOfSteps(const System& system) {
  return system.linearSolver()->isMadeForAnother() && !hasLinearForces(system) ? 0.1 : 0;
}

}  // namespace stroma
