// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/scene/usual_component.h"

namespace stroma {

std::string usualComponent(Part part) {
  switch (part) {
    case Part::state:
      return "MechanicalObject";
    case Part::mass:
      return "UniformMass";
    case Part::diagonal_mass:
      return "DiagonalMass";
    case Part::integrator:
      return "EulerImplicitSolver";
    case Part::solver_in_time:
      return "PCGLinearSolver";
    case Part::solver_that_chooses:
      return "AutomaticLinearSolver";
    case Part::ball:
      return "BallForceField";
    case Part::solver_of_equilibria:
      break;
  }
  return "SparseLDLSolver";
}

}  // namespace stroma
