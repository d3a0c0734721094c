// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>

#include "framework/algebra/solver_choice.h"
#include "framework/simulation/system.h"

namespace stroma {

/// The forcing term of statics whose scene writes none: with a linear solver that chooses its method, which does so here,
/// early solves are loose, unless forces are affine in x and one solve is the solution. 0 with solvers that a scene names:
/// their tolerance is theirs.
inline double usualForcing(System& system) {
  auto* choosing = dynamic_cast<SolverChoice*>(system.linearSolver());
  if (!choosing) return 0;
  choosing->choose(system.matrix());
  const auto& fields = system.forceFields();
  const auto is_linear = [](const ForceField* field) { return field->traits().linear; };
  return std::all_of(fields.begin(), fields.end(), is_linear) ? 0 : 0.1;
}

}  // namespace stroma
