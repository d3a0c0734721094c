// SPDX-License-Identifier: LGPL-2.1-or-later
// What ends SOFA's iterative searches: absolute numbers, in the units of the unknown that an integrator solves for.
#include <cstdlib>

#include "tools/sofa/rewriting.h"

namespace stroma::sofa {

/// The search of an integrator whose unknown SOFA counts in other units, or null. Conjugate gradients alone have such an end.
Element* Rewriting::searchOf(const Element& integrator) {
  Element* solver = integrator.place->firstOf("linear solver");
  return solver && isAnyOf(solver->written->type, {"CGLinearSolver", "PCGLinearSolver"}) ? solver : nullptr;
}

void Rewriting::meanSearch(Element& solver) {
  setDefault(solver, "iterations", "25");
  setDefault(solver, "tolerance", "1e-05");
  if (solver.is("PCGLinearSolver")) setQuirk(solver, "cg-threshold", "endsBySquares", "true");
  if (!solver.is("CGLinearSolver")) return;
  std::string threshold = solver.find("threshold") ? solver.text("threshold") : "1e-05";
  const bool is_number = threshold.find('@') == std::string::npos;
  const Element* integrator = solver.place->firstOf("integrator");
  if (is_number && integrator && integrator->is("NewmarkImplicitSolver") && searchOf(*integrator) == &solver) {
    const double gamma = integrator->find("gamma") ? std::atof(integrator->text("gamma").c_str()) : 0.5, unit = gamma * timeStep();
    threshold = printReal(std::atof(threshold.c_str()) * unit * unit);  // of accelerations there, of changes of velocity here
  }
  if (is_number && !(std::atof(threshold.c_str()) > 0)) threshold = "1e-300";  // nothing falls below it
  solver.remove("threshold");
  setDefault(solver, "preconditioner", "none");
  setQuirk(solver, "cg-threshold", "absoluteThreshold", threshold);
}

}  // namespace stroma::sofa
