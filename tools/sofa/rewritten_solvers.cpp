// SPDX-License-Identifier: LGPL-2.1-or-later
// What integrators and solvers mean in SOFA: their defaults, and what ends an iteration.
#include <algorithm>
#include <cstdlib>

#include "framework/scene/names.h"
#include "framework/scene/text.h"
#include "tools/sofa/rewriting.h"

namespace stroma::sofa {

/// Lagrangian constraints, or contacts with friction.
bool Rewriting::hasForcesOfConstraint() const {
  bool found = false;
  tree_->forEach([&found](Element& each) {
    const bool answers = each.text("response").find("Constraint") != std::string::npos;
    found = found || each.role() == "Lagrangian constraint" || (answers && !each.dropped);
  });
  return found;
}

/// Cables and cavities of SoftRobots, which are to hold what they are told and keep the rounds they need for it.
bool Rewriting::hasActuators() const {
  bool found = false;
  tree_->forEach([&found](Element& each) { found = found || isActuator(each); });
  return found;
}

void Rewriting::meanVariational(Element& element) {
  setDefault(element, "steps", "5");
  setDefault(element, "newtonError", "0.01");
  if (saysYes(element.text("explicitIntegration"))) {
    if (element.find("rayleighStiffness")) noEffect(element.written->type + ".rayleighStiffness, which explicit steps do not know");
    element.remove("rayleighStiffness");
  } else if (hasForcesOfConstraint()) {
    warn(element.written->where, element, "newtonError",
         "ends iterations where positions change little in SOFA, whose Rayleigh damping is in the matrix alone: here it is of "
         "the forces, and both damp");
  } else {
    setQuirk(element, "one-iteration", "byPositions", "true");
  }
}

/// The factor by which a mass or a force field damps itself.
static const char* dampingOf(const Element& element) {
  return element.role() == "mass" ? "rayleighMass" : element.role() == "force field" ? "rayleighStiffness" : "";
}

/// A force field or mass at or below this place that the scene damps by itself.
static bool dampsItself(const Place& place) {
  const auto damps = [](const auto& element) {
    const char* name = dampingOf(*element);
    return !element->dropped && *name && std::atof(element->text(name).c_str()) != 0;
  };
  const auto has_one = [](const auto& child) { return !child->dropped && dampsItself(*child); };
  return std::any_of(place.elements.begin(), place.elements.end(), damps) ||
         std::any_of(place.children.begin(), place.children.end(), has_one);
}

void Rewriting::findOwnDamping() {
  tree_->forEach([this](Element& element) {
    if (element.is("EulerImplicitSolver") && dampsItself(*element.place))
      own_damping_[&element] = {element.text("rayleighStiffness"), element.text("rayleighMass")};
  });
}

/// Masses and force fields that damp themselves, where SOFA's integrator asks for none of it. Gives what was left out.
static std::vector<std::string> leaveOutDampingOfParts(SceneTree& tree, const Element& integrator) {
  std::vector<std::string> left_out;
  tree.forEach([&](Element& part) {
    const char* name = dampingOf(part);
    if (!*name || part.dropped || part.place->nearest("integrator") != &integrator || std::atof(part.text(name).c_str()) == 0) return;
    left_out.push_back(part.written->type + "." + name + ", which " + integrator.written->type + " does not know");
    part.remove(name);
  });
  return left_out;
}

void Rewriting::meanSolver(Element& element) {
  const std::string& type = element.written->type;
  if (isAnyOf(type, {"CGLinearSolver", "PCGLinearSolver", "MinResLinearSolver"})) meanSearch(element);
  if (type == "NewmarkImplicitSolver" && searchOf(element)) setQuirk(element, "cg-threshold", "fromZeroAcceleration", "true");
  if (type == "EulerImplicitSolver" && !saysYes(element.text("trapezoidalScheme"))) setDefault(element, "allowMassless", "true");
  for (const char* implicit : {"EulerImplicitSolver", "TrapezoidalRuleSolver", "NewmarkImplicitSolver", "BDFOdeSolver"})
    if (type == implicit) setDefault(element, "newtonIterations", "1");
  if (type == "EulerImplicitSolver" && saysYes(element.text("trapezoidalScheme")))
    setQuirk(element, "trapezoidal-positions", "moveByNewVelocity", "true");
  const auto own = own_damping_.find(&element);
  if (own != own_damping_.end() && own->second == std::pair(element.text("rayleighStiffness"), element.text("rayleighMass")))
    setQuirk(element, "explicit-damping", "ownInMatrix", "true");
  if (type == "BDFOdeSolver") meanMultiStep(element);
  if (type == "CentralDifferenceSolver") setQuirk(element, "whole-first-step", "firstStep", "whole");
  const auto isDamped = [&element](const char* name) { return std::atof(element.text(name).c_str()) != 0; };
  if (type == "CentralDifferenceSolver" && isDamped("rayleighMass")) setQuirk(element, "explicit-damping", "dampsHeld", "true");
  if (type == "NewmarkImplicitSolver" && (isDamped("rayleighMass") || isDamped("rayleighStiffness") || dampsItself(*element.place)))
    setQuirk(element, "explicit-damping", "undampedStart", "true");
  if (isAnyOf(type, {"EulerExplicitSolver", "RungeKutta2Solver", "RungeKutta4Solver", "CentralDifferenceSolver", "NewtonCotesSolver",
                     "StaticSolver"}))
    for (const std::string& part : leaveOutDampingOfParts(*tree_, element)) noEffect(part);
  if (type == "VariationalSymplecticSolver") meanVariational(element);
  if (type == "EulerImplicitSolver" && hasForcesOfConstraint() && !hasActuators()) setQuirk(element, "one-iteration", "oneRound", "true");
  if (element.role() == "integrator" && hasForcesOfConstraint() && hasActuators() && quirks_.isOn("one-iteration"))
    warn(element.written->where, element, {},
         "finds forces of constraint until cables and cavities hold at the end of a step: SOFA finds them once, in the directions of "
         "the motion without them, and differs while bodies move far in a step");
  if (type == "StaticSolver") meanStatics(element);
  if (type == "NewtonRaphsonSolver") meanNewton(element);
}

/// A component of a role stands in the place or below.
static bool holdsRole(const Place& place, std::string_view role) {
  return place.has(role) || std::any_of(place.children.begin(), place.children.end(),
                                        [role](const auto& child) { return !child->dropped && holdsRole(*child, role); });
}

/// A switch of a matrix, for parts of which there are none where it counts: below the integrator whose solver has it. What has no
/// integrator is asked of the whole scene.
bool Rewriting::isIdleSwitch(std::string_view name, const Element& system) const {
  const bool of_constraints = name == "applyProjectiveConstraints";
  if (!of_constraints && !isAnyOf(name, {"applyMappedComponents", "assembleGeometricStiffness"})) return false;
  bool acts = false;
  const auto ask = [&](const Place& place) {
    const Element* integrator = place.nearest("integrator");
    acts = acts || holdsRole(integrator ? *integrator->place : tree_->root(), of_constraints ? "projective constraint" : "mapping");
  };
  ask(*system.place);
  tree_->forEach([&](Element& asker) {
    for (const AttributeDescription& attribute : asker.written->attributes)
      forLinks(attribute, [&](std::string_view link) {
        if (tree_->follow(asker, link, false).element == &system) ask(*asker.place);
      });
  });
  return !acts;
}

/// SOFA's thresholds below zero are off; without a NewtonRaphsonSolver it makes one.
void Rewriting::meanStatics(Element& solver) {
  const char* thresholds[] = {"absolute_residual_tolerance_threshold", "relative_residual_tolerance_threshold",
                              "absolute_correction_tolerance_threshold", "relative_correction_tolerance_threshold"};
  for (const char* name : thresholds)
    if (solver.text(name).starts_with("-")) solver.set(name, "0");
  if (solver.find("newtonSolver") || solver.place->has("Newton solver")) {
    for (const char* name : {"newton_iterations", thresholds[0], thresholds[1], thresholds[2], thresholds[3]}) {
      if (!solver.find(name)) continue;
      warn(solver.find(name)->where, solver, name, "does not count: NewtonRaphsonSolver holds the settings");
      solver.remove(name);
    }
    return;
  }
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

/// A step of SOFA's begins at x + h v, and is over where its residual there is below Newton's absolute threshold.
void Rewriting::meanMultiStep(Element& solver) {
  const std::string link = solver.text("newtonSolver");
  const Element* newton = link.empty() ? solver.place->firstOf("Newton solver") : tree_->follow(solver, link, false).element;
  std::string threshold = "1e-05";
  if (newton && newton->find("absoluteResidualStoppingThreshold")) threshold = newton->text("absoluteResidualStoppingThreshold");
  if (!newton)
    warn(solver.written->where, solver, "newtonSolver",
         "leads to no NewtonRaphsonSolver: SOFA moves nothing then, and here the solver has its defaults");
  if (std::atoi(solver.text("order").c_str()) == 2) setQuirk(solver, "predicted-start", "firstStep", "euler");
  setQuirk(solver, "predicted-start", "startFrom", "predicted");
  setQuirk(solver, "predicted-start", "restBelow", threshold.starts_with("-") ? "0" : threshold);
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

/// Of "NAME?mu=0.6&epsilon=3" what there is here, or empty; `mu`: that of all contacts, where a solver has one.
std::string Rewriting::answerHere(const Element& element, const std::string& attribute, const std::string& word,
                                  const std::string& mu) {
  const auto mark = word.find('?');
  std::string name = word.substr(0, mark), parameters;
  if (mark != std::string::npos)
    for (std::size_t at = mark + 1; at < word.size();) {  // of augmented Lagrangians also epsilon, how fast they get there
      const std::size_t end = std::min(word.find('&', at), word.size());
      if (const std::string part = word.substr(at, end - at); !part.starts_with("epsilon="))
        parameters += (parameters.empty() ? "" : "&") + part;
      at = end + 1;
    }
  if (name.starts_with("AugmentedLagrangian")) {
    warn(element.written->where, element, attribute, "SOFA comes near the forces of constraint step by step: here they hold");
    name = "FrictionContactConstraint";
  } else if (name == "StickContactConstraint") {
    warn(element.written->where, element, attribute,
         "keeps together in SOFA what has touched: here friction holds it, and it may come apart again");
    name = "FrictionContactConstraint", parameters = "mu=100";
  } else if (!isAnyOf(name, {"", "default", "PenalityContactForceField", "FrictionContactConstraint", "FrictionContact"})) {
    return {};
  }
  if (name.starts_with("Friction") && !mu.empty()) parameters = "mu=" + mu;
  return parameters.empty() ? name : name + "?" + parameters;
}

/// In rules $NAME$ stands for the word that is the attribute NAME.
void Rewriting::fillVariables(Element& response) {
  std::string text = response.text("rules");
  const std::string names = response.text("variables");
  Words variables(names);
  for (std::string name(variables.next()); !name.empty(); name = variables.next()) {
    const std::string value = response.text(name), mark = "$" + name + "$";
    for (auto at = text.find(mark); at != std::string::npos; at = text.find(mark, at + value.size()))
      text.replace(at, mark.size(), value);
    response.remove(name);
  }
  response.remove("variables");
  if (response.find("rules")) response.set("rules", text);
}

/// The responses of pairs of models, by rules, and those of models.
void Rewriting::meanRules(Element& response, const std::string& mu) {
  std::vector<std::string> words;
  const std::string text = response.text("rules");
  Words written(text);
  for (std::string word(written.next()); !word.empty(); word = written.next()) words.push_back(word);
  if (words.size() % 3 != 0)
    warn(response.written->where, response, "rules",
         "has " + std::to_string(words.size()) + " words: the last rule lacks some and does not count");
  std::string rules;
  for (std::size_t i = 2; i < words.size(); i += 3)
    if (const std::string answer = answerHere(response, "rules", words[i], mu); !answer.empty())
      rules += (rules.empty() ? "" : " ") + words[i - 2] + " " + words[i - 1] + " " + answer;
    else
      warn(response.written->where, response, "rules",
           inQuotes(words[i]) + " is no response here: those that it names have that of all");
  if (response.find("rules")) response.set("rules", rules);
  tree_->forEach([&](Element& model) {
    if (model.role() != "collision model" || !model.find("contactResponse")) return;
    const std::string word = model.text("contactResponse");
    const std::string answer = word.empty() ? word : answerHere(model, "contactResponse", word, mu);
    if (answer.empty() && !word.empty())
      warn(model.written->where, model, "contactResponse", inQuotes(word) + " is no response here: it has that of all");
    answer.empty() ? model.remove("contactResponse") : model.set("contactResponse", answer);
  });
}

/// SOFA's LCPConstraintSolver has one coefficient of friction for all contacts, whatever they were given.
void Rewriting::takeFriction(Element& response) {
  const Element *solver = nullptr, *method = nullptr;
  bool groups = false;  // bodies that touch have one solver then
  tree_->forEachPlace([&](Place& place) {  // accepted, and no part any more
    for (const auto& each : place.elements) {
      if (each->is("LCPConstraintSolver")) solver = each.get();
      if (each->role() == "intersection method") method = each.get();
      groups = groups || each->is("CollisionGroup") || each->written->type.ends_with("GroupManager");
    }
  });
  const std::string mu = !solver ? "" : solver->find("mu") ? solver->text("mu") : "0.6";
  meanRules(response, mu);
  const std::string word = response.text("response");
  const auto old = word.find('?');  // an older way: "FrictionContactConstraint?mu=0.7"
  std::string parameters = response.text("responseParams");
  if (parameters.empty() && old != std::string::npos) parameters = word.substr(old + 1);
  const std::string answer =
      word.empty() ? word : answerHere(response, "response", word.substr(0, old) + "?" + parameters, "");
  if (!answer.empty()) {
    const auto mark = answer.find('?');
    response.set("response", answer.substr(0, mark));
    if (mark != std::string::npos) response.set("responseParams", answer.substr(mark + 1));
  }
  if (word.empty()) response.set("response", "PenalityContactForceField");
  const bool pushes = isAnyOf(response.text("response"), {"default", "PenalityContactForceField"});
  if (pushes && !groups && !response.place->nearest("integrator")) setQuirk(response, "isolated-springs", "explicitBetween", "true");
  listContacts(response, method);
  const bool rubs = response.text("response").find("Friction") != std::string::npos;
  const bool some_rub = rubs || response.text("rules").find("Friction") != std::string::npos;
  if (some_rub) findsForcesOfConstraint(response);
  // SOFA's solvers end at their maxIterations, and the run goes on
  if (some_rub && method)
    setDefault(response, "toleratedError", method->find("contactDistance") ? method->text("contactDistance") : "0.5");
  if (!rubs || !solver) return;
  const std::string given = response.text("responseParams");
  const auto at = given.find("mu=");
  const double own = at == std::string::npos ? -1 : std::atof(given.c_str() + at + 3);
  if (own == 0 || own == std::atof(mu.c_str())) return;
  if (own > 0)
    warn(response.written->where, response, "responseParams",
         "does not count: LCPConstraintSolver takes its own mu=" + mu + " for all contacts");
  response.set("responseParams", "mu=" + mu);
}

/// What is accepted, and in SOFA may do something to the numbers.
void Rewriting::warnOfAccepted(const Element& element) {
  if (element.written->type.starts_with("Python"))
    return warn(element.written->where, element, {}, "is a script that SOFA runs: what it does to the scene is not done here");
  if (element.is("FreeMotionAnimationLoop") && saysYes(element.text("solveVelocityConstraintFirst")) && hasForcesOfConstraint())
    return warn(element.written->where, element, "solveVelocityConstraintFirst",
                "finds forces of constraint twice in SOFA, for velocities and then for positions: here once, for both");
  const std::string factor = element.text("complianceFactor");
  if (element.written->type.ends_with("ConstraintCorrection") && !factor.empty() && std::atof(factor.c_str()) != 1)
    warn(element.written->where, element, "complianceFactor", "changes how far SOFA's forces of constraint move nodes: here by the matrix");
  if (element.written->type.ends_with("ConstraintCorrection") && std::atof(element.text("regularizationTerm").c_str()) != 0)
    return warn(element.written->where, element, "regularizationTerm", "makes constraints soft in SOFA: here they hold");
  if (element.is("DataExchange"))
    return warn(element.written->where, element, {},
                "copies values between parts of a scene that SOFA computes at the same time: not done here", "a link to the data");
  if (element.is("MultiTagAnimationLoop"))
    return warn(element.written->where, element, {},
                "animates what has one tag after what has another, and nothing that has none: here all move together");
  if (!element.is("PrecomputedConstraintCorrection")) return;
  bool pulls = element.find("compliance") || element.find("defaultCompliance"), holds = false;
  tree_->forEach([&](Element& each) {
    const Place* place = each.place;
    while (place && place != element.place) place = place->parent;
    pulls = pulls || (place && each.role() == "force field");
    holds = holds || each.written->type.ends_with("LagrangianConstraint") || isActuator(each) ||
            each.text("response").find("Constraint") != std::string::npos || each.text("response").find("Friction") != std::string::npos;
  });
  if (pulls && holds)
    warn(element.written->where, element, {},
         "SOFA moves nodes by forces of constraint with the compliance of the start: here it is that of the step");
}

/// A force or a pressure that is written, and the one that is told after a step.
void Rewriting::meanActuator(Element& element) {
  setQuirk(element, "impulse-values", "impulses", "true");
  if (!element.is("PositionConstraint")) return;
  const auto warnOf = [&](const char* attribute, const std::string& what) { warn(element.written->where, element, attribute, what); };
  const std::vector<double> used = writtenNumbers(element.text("useDirections")), weights = writtenNumbers(element.text("weight"));
  if (!used.empty() && std::all_of(used.begin(), used.end(), [](double one) { return one == 0; })) {
    warnOf("useDirections", "holds no direction: as in SOFA all are taken");
    element.remove("useDirections");
  }
  const Element* state = element.place->nearest("mechanical state");
  const std::size_t count = state && state->text("template").starts_with("Rigid") ? 6 : 3;
  if (weights.size() < 2 || weights.size() == count) return;
  warnOf("weight", "has " + std::to_string(weights.size()) + " numbers for " + std::to_string(count) +
                       " directions: as in SOFA the first is that of all");
  element.set("weight", printReal(weights[0]));
}

/// Forces of constraint that leave out the matrix of a body: where there are any, and unless they are not wanted.
void Rewriting::meanCorrection(Element& correction) {
  const bool counts = hasForcesOfConstraint() && correction.place->has("mechanical state");
  if (counts && quirks_.use("one-iteration", correction.path())) return;
  correction.dropped = true;
  noEffect(correction.written->type);
}

/// Tangents of SOFA that are not the derivatives of the forces, and are not followed.
void Rewriting::warnOfTangents(const Element& field) {
  const std::string_view type = field.written->type;
  const std::vector<double> c = writtenNumbers(field.text("ParameterSet"));
  if (type == "StandardTetrahedralFEMForceField" && field.text("materialName") == "MooneyRivlin" && c.size() > 1 && c[1] != 0)
    warn(field.written->where, field, "materialName",
         "has its exact tangent: SOFA's lacks a part of c2, and implicit steps differ by some thousandths");
  if (type.ends_with("FEMForceField") && field.text("materialName") == "Costa" && c.size() > 1)
    warn(field.written->where, field, "materialName",
         "has its exact tangent: SOFA's lacks the factor k0 in a term, and implicit steps that change volumes differ");
  const Element* integrator = field.place->nearest("integrator");
  const std::string rule = integrator ? integrator->written->type : "";
  const bool is_explicit = rule.starts_with("EulerExplicit") || rule.starts_with("CentralDiff") || rule.starts_with("RungeKutta");
  if (type == "TriangularBiquadraticSpringsForceField" && !is_explicit && !saysNo(field.text("compressible")))
    warn(field.written->where, field, "compressible",
         "has its exact tangent where triangles lose area: SOFA's is milder there, and implicit steps differ");
  const Element* solver = field.place->nearest("linear solver");
  if (type == "FastTetrahedralCorotationalForceField" && solver && solver->is("SparseLDLSolver"))
    warn(field.written->where, field, {},
         "has its exact tangent: in SOFA's assembled matrix some blocks are transposed, and implicit steps differ by some hundredths");
}

}  // namespace stroma::sofa
