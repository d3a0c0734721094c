// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>

#include "components/iterative_solvers/equilibrium_choice.h"
#include "components/iterative_solvers/former_solutions.h"
#include "components/iterative_solvers/mixed_solve.h"
#include "components/iterative_solvers/multigrid.h"
#include "components/iterative_solvers/scaled_gmres.h"
#include "components/iterative_solvers/warped_factor.h"

namespace stroma {

/// What AutomaticLinearSolver keeps for a matrix.
struct EquilibriumMemory {
  EquilibriumChoice now, before_step;
  std::string reason;     ///< of the first choice, in words
  bool symmetric = true;  ///< the matrix solved last
  SolverCosts costs;      ///< by which it was chosen
  Multigrid inverse;
  std::unique_ptr<MixedSolve> mixed;     ///< null: not needed so far
  std::unique_ptr<WarpedFactor> turned;  ///< null: not needed so far
  cg::Directions work;
  LightRows light;
  cg::FormerSolutions former;
  ScaledGmres scaled;  ///< of matrices that are not symmetric

  /// Iterations of a solve by multigrid.
  int patience() const {
    const amg::Hierarchy* hierarchy = inverse.hierarchy();
    return hierarchy && hierarchy->hasPatches() ? now.patience / 2 : now.patience;
  }
  void reset() {
    inverse.reset(), former.reset(), mixed = nullptr, now = {};
    if (turned) turned->reset();
  }
  /// See LinearSolver::keepFor().
  void keep(const SystemMatrix& matrix, bool forgets_pressures) {
    before_step = now;
    inverse.keep(matrix), former.keep();
    if (forgets_pressures) mixed->reset();
    if (turned) turned->keep(matrix);
  }
  void takeBack(const SystemMatrix& matrix, bool forgets_pressures) {
    now = before_step;
    inverse.takeBack(matrix), former.takeBack();
    if (forgets_pressures) mixed->reset();
    if (turned) turned->takeBack(matrix);
  }
  /// Of pressures, for a matrix that does not depend on the state.
  void serializePlaces(Archive& archive) {
    if (!mixed) mixed = std::make_unique<MixedSolve>();
    mixed->serialize(archive);
  }
};

}  // namespace stroma
