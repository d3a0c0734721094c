// SPDX-License-Identifier: LGPL-2.1-or-later
// What integrators and solvers mean in SOFA: their defaults, and what ends an iteration.
#include "framework/scene/names.h"
#include "tools/sofa/rewriting.h"

namespace stroma::sofa {

void Rewriting::meanSolver(Element& element) {
  const std::string& type = element.written->type;
  if (type == "CGLinearSolver" || type == "PCGLinearSolver" || type == "MinResLinearSolver") {
    setDefault(element, "iterations", "25");
    setDefault(element, "tolerance", "1e-05");
  }
  if (type == "CGLinearSolver") {
    const std::string threshold = element.find("threshold") ? element.text("threshold") : "1e-05";
    element.remove("threshold");
    setDefault(element, "preconditioner", "none");
    setQuirk(element, "cg-threshold", "absoluteThreshold", threshold);
  }
  if (type == "EulerImplicitSolver" && saysYes(element.text("trapezoidalScheme")))
    setQuirk(element, "trapezoidal-positions", "moveByNewVelocity", "true");
  if (type == "VariationalSymplecticSolver") {
    setDefault(element, "steps", "5");
    setDefault(element, "newtonError", "0.01");
  }
  if (type == "StaticSolver") meanStatics(element);
  if (type == "NewtonRaphsonSolver") meanNewton(element);
}

/// SOFA's thresholds below zero are off; without a NewtonRaphsonSolver it makes one.
void Rewriting::meanStatics(Element& solver) {
  const char* thresholds[] = {"absolute_residual_tolerance_threshold", "relative_residual_tolerance_threshold",
                              "absolute_correction_tolerance_threshold", "relative_correction_tolerance_threshold"};
  for (const char* name : thresholds)
    if (solver.text(name).starts_with("-")) solver.set(name, "0");
  if (solver.find("newtonSolver") || solver.place->has("Newton solver")) return;
  const std::string count = solver.find("newton_iterations") ? solver.text("newton_iterations") : "1";
  if (count != "1" || !quirks_.use("one-iteration", solver.path())) {
    if (count == "1") return;
    for (const char* name : thresholds) setDefault(solver, name, "1e-05");
    return;
  }
  for (const char* name : thresholds) solver.remove(name);
  solver.remove("newton_iterations");
  const SourceLocation& where = solver.written->where;
  const std::string name = solver.name + "_newton";
  solver.place->added_components.push_back({"NewtonRaphsonSolver",
                                            {{"name", name, where},
                                             {"maxNbIterationsNewton", "1", where},
                                             {"maxNbIterationsLineSearch", "0", where},
                                             {"relativeSuccessiveStoppingThreshold", "1e300", where}},
                                            where,
                                            solver.written->folder});
  SceneTree::linkTo(solver);  // nodes above it have names from now on
  solver.set("newtonSolver", "@" + joinPath(solver.place->path(), name));
}

void Rewriting::meanNewton(Element& newton) {
  const bool is_one = !newton.find("maxNbIterationsNewton") || newton.text("maxNbIterationsNewton") == "1";
  if (is_one && quirks_.use("one-iteration", newton.path())) {  // whatever it leaves is the step's result
    newton.set("maxNbIterationsNewton", "1");
    const std::string trials = newton.text("maxNbIterationsLineSearch");
    if (trials.empty() || trials == "1") newton.set("maxNbIterationsLineSearch", "0");  // one trial takes the whole step
    newton.set("relativeSuccessiveStoppingThreshold", "1e300");
  } else if (!is_one) {
    for (const char* name : {"relativeSuccessiveStoppingThreshold", "relativeInitialStoppingThreshold",
                             "absoluteResidualStoppingThreshold"})
      setDefault(newton, name, "1e-05");
  }
}

}  // namespace stroma::sofa
