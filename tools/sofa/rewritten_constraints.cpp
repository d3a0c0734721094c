// SPDX-License-Identifier: LGPL-2.1-or-later
// What constraints that hold nodes mean in SOFA.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <set>

#include "framework/scene/text.h"
#include "tools/sofa/rewriting.h"

namespace stroma::sofa {

/// Its linear solver is given a matrix, and not products with one.
bool Rewriting::isAssembled(const Element& integrator) const {
  const Element* solver = integrator.place->nearest("linear solver");
  if (const std::string link = integrator.text("linearSolver"); !link.empty())
    if (const LinkTarget target = tree_->follow(integrator, link, false); target.element) solver = target.element;
  if (!solver || solver->is("PCGLinearSolver")) return false;
  const bool iterates = solver->is("CGLinearSolver") || solver->is("MinResLinearSolver");
  return !iterates || solver->text("template").starts_with("Compressed");
}

/// The bodies that a constraint is of have rigid frames.
bool Rewriting::isOfFrames(const Element& constraint) const {
  const Element* state = constraint.place->nearest("mechanical state");
  for (const char* name : {"object1", "mstate"})
    if (const std::string link = constraint.text(name); !link.empty()) {
      const LinkTarget target = tree_->follow(constraint, link, false);
      state = target.element ? target.element : target.place ? target.place->firstOf("mechanical state") : state;
    }
  return state && state->text("template").starts_with("Rigid");
}

/// Some constraints of SOFA do not know how to change a matrix that is assembled: it is solved with all nodes free, for a right side
/// without what they hold, and they project positions and velocities afterwards.
void Rewriting::meanMatrix(Element& element, const Element& integrator) {
  const bool is_pair = element.is("AttachProjectiveConstraint") && saysYes(element.text("twoWay"));
  if (!is_pair && !isAnyOf(element.written->type, {"ProjectToLineProjectiveConstraint", "ProjectToPlaneProjectiveConstraint",
                                                   "DirectionProjectiveConstraint", "OscillatorProjectiveConstraint",
                                                   "ParabolicProjectiveConstraint", "HermiteSplineProjectiveConstraint",
                                                   "PatchTestMovementProjectiveConstraint", "AffineMovementProjectiveConstraint"}))
    return;
  const bool is_explicit = isAnyOf(integrator.written->type, {"EulerExplicitSolver", "CentralDifferenceSolver"}) ||
                           integrator.written->type.starts_with("RungeKutta");
  const Element* mass = element.place->firstOf("mass");
  const bool is_coupled = mass && mass->is("MeshMatrixMass") && !saysYes(mass->text("lumping"));
  if ((is_explicit && !is_coupled) || !isAssembled(integrator)) return;
  const std::string iterations = integrator.text("newtonIterations");
  const bool solves_once = integrator.is("EulerImplicitSolver") && isAnyOf(iterations, {"", "1"}) && !integrator.find("newtonSolver");
  if (solves_once && !hasForcesOfConstraint() && !(is_pair && isOfFrames(element)))
    return setQuirk(element, "unheld-matrix", "inMatrix", "false");
  warn(element.written->where, element, {},
       "holds its nodes in the matrix of " + integrator.path() + ": SOFA solves with them free where the matrix is assembled, and puts "
       "them back after the step, so that their neighbours move otherwise",
       "CGLinearSolver, with which both do the same");
}

/// What SOFA's released assembled matrices do with pairs that come free, and how its products answer factors.
void Rewriting::meanPairs(Element& pairs, bool is_assembled) {
  const bool both = saysYes(pairs.text("twoWay"));
  const auto isBelow = [&pairs](const char* name) {
    for (const double each : writtenNumbers(pairs.text(name)))
      if (each != 1) return true;
    return false;
  };
  if (both && !is_assembled && (isBelow("responseFactor") || isBelow("constraintFactor"))) {
    pairs.set("inMatrix", "false"), pairs.set("responseFactor", "0");
    warn(pairs.written->where, pairs, {},
         "has factors below 1: SOFA's conjugate gradients then go to the velocities of nodes that are free, which are computed here");
  }
  if (both || !is_assembled) return;
  const std::vector<double> nodes = writtenNumbers(pairs.text("indices2"));
  if (pairs.find("lastDir") && !saysYes(pairs.text("clamp")) && nodes.size() > 1)
    warn(pairs.written->where, pairs, "lastDir",
         "frees pairs one by one: SOFA's assembled matrix asks other pairs than those of its vectors, and free nodes move otherwise",
         "CGLinearSolver, with which both do the same");
  if (pairs.find("minDistance") && writtenNumbers(pairs.text("minDistance")) != std::vector<double>{-1})
    warn(pairs.written->where, pairs, "minDistance",
         "frees nodes: in SOFA's assembled matrix they still feel no forces, and go on as they were",
         "CGLinearSolver, with which both do the same");
}

/// The frames of a skeleton that a program moves: without joints they all stay.
void Rewriting::meanSkeleton(Element& constraint) {
  for (const char* name : {"joints", "bones"})
    if (const AttributeDescription* given = constraint.find(name); given && !trimmed(given->value).empty())
      diagnostics_.error(given->where, constraint.path() + "." + name, "the movement of a skeleton is not available here",
                         "movements of single frames: LinearMovementProjectiveConstraint");
  if (saysNo(constraint.text("active"))) {
    constraint.dropped = true;
    return diagnostics_.note(constraint.written->where, constraint.path(), "is not active");
  }
  for (const char* name : {"joints", "bones", "animationSpeed", "active"}) constraint.remove(name);
  constraint.set("fixAll", "true");
  warn(constraint.written->where, constraint, {}, "has no joints: its frames stay where they are, as in SOFA");
}

/// An element of a type that ends so, also of those that are accepted and no part any more.
static bool holdsType(const Place& place, std::string_view ending) {
  return std::any_of(place.elements.begin(), place.elements.end(),
                     [ending](const auto& each) { return each->written->type.ends_with(ending); });
}

/// SOFA looks for forces of constraint where a loop or a solver for them is, and moves bodies by them that have a correction.
bool Rewriting::findsForcesOfConstraint(const Element& asker) {
  bool finds = false;
  tree_->forEachPlace([&finds](Place& place) {
    for (const char* ending : {"FreeMotionAnimationLoop", "ConstraintAnimationLoop", "MultiTagAnimationLoop", "ConstraintSolver"})
      finds = finds || holdsType(place, ending);
  });
  if (!finds)
    warn(asker.written->where, asker, {},
         "acts here: in SOFA nothing finds forces of constraint without a FreeMotionAnimationLoop, and it does nothing");
  return finds;
}

void Rewriting::meanForceOfConstraint(const Element& constraint) {
  if (!findsForcesOfConstraint(constraint)) return;
  for (const char* name : {"object1", "object2"}) {
    const std::string link = constraint.text(name);
    const LinkTarget target = link.empty() ? LinkTarget{nullptr, constraint.place, {}} : tree_->follow(constraint, link, false);
    const Place* place = target.element ? target.element->place : target.place;
    bool corrected = !place || !place->nearest("integrator");
    for (; place && !corrected; place = place->parent) corrected = holdsType(*place, "ConstraintCorrection");
    if (!corrected && (!link.empty() || name == std::string_view("object1")))
      return warn(constraint.written->where, constraint, link.empty() ? "" : name,
                  "moves a body that has no constraint correction: in SOFA forces of constraint do not move it",
                  "a LinearSolverConstraintCorrection in its node");
  }
}

/// SOFA takes the direction as it is given, and holds nodes in an assembled matrix along each axis that it has a part of.
void Rewriting::meanSlidingPlane(Element& plane, bool is_assembled) {
  const std::vector<double> given = plane.writes("direction") ? writtenNumbers(plane.text("direction")) : std::vector<double>();
  if (given.size() < 3) return;
  const double length = Vec3(given[0], given[1], given[2]).norm();
  constexpr double round_off = 1e-6;  // of a direction that is written with six digits
  if (length > 0 && std::abs(length - 1) > round_off) {
    warn(plane.find("direction")->where, plane, "direction",
         "has the length " + printReal(length) + ": SOFA takes it as it is, and forces across the plane go on to move the nodes there",
         "a direction of length 1");
    for (const char* name : {"dmin", "dmax"})
      if (plane.writes(name)) plane.set(name, printReal(std::atof(plane.text(name).c_str()) / length));
  }
  if (is_assembled && (given[0] != 0) + (given[1] != 0) + (given[2] != 0) > 1)
    warn(plane.find("direction")->where, plane, "direction",
         "is along no axis: in SOFA's assembled matrix nodes have no mass and no neighbours along the axes that it has a part of, and they "
         "slide otherwise",
         "CGLinearSolver, with which both do the same");
}

bool holdsFirstNode(const std::string& type) {
  static const std::set<std::string> first = {"FixedProjectiveConstraint", "PartialFixedProjectiveConstraint",
                                              "FixedTranslationProjectiveConstraint", "LinearMovementProjectiveConstraint",
                                              "PartialLinearMovementProjectiveConstraint", "DirectionProjectiveConstraint",
                                              "ProjectToPointProjectiveConstraint", "ProjectToLineProjectiveConstraint",
                                              "ProjectToPlaneProjectiveConstraint"};
  return first.count(type) > 0;
}

void Rewriting::meanConstraint(Element& element) {
  if (element.is("InterventionalRadiologyController") && std::atof(element.text("speed").c_str()) < 0 && !element.find("motionFilename")) {
    warn(element.find("speed")->where, element, "speed", "is below 0: SOFA moves rods of a scene by a speed above 0 only, and they stay");
    element.remove("speed");
  }
  const Element* integrator = element.place->nearest("integrator");
  const bool moves = integrator && !integrator->is("StaticSolver") && !element.place->has("mapping");
  if (element.is("FixedRotationProjectiveConstraint") && moves && quirks_.use("one-sided-turns", element.path()))
    return tree_->retype(element, "TwistConstraint");
  const bool is_taken = element.is("FixedTranslationProjectiveConstraint") && isOfFrames(element);  // SOFA takes torques out too
  if (is_taken && quirks_.use("one-sided-turns", element.path())) tree_->retype(element, "FixedProjectiveConstraint");
  if (is_taken && moves && element.is("FixedProjectiveConstraint") && isAssembled(*integrator) && integrator->is("EulerImplicitSolver") &&
      !hasForcesOfConstraint())
    setQuirk(element, "unheld-matrix", "inMatrix", "false");
  if (integrator && !element.place->has("mapping")) meanMatrix(element, *integrator);
  if (element.is("AttachProjectiveConstraint") && integrator) meanPairs(element, isAssembled(*integrator));
  setDefault(element, "ignoreMissing", "true");
  setDefault(element, "startsThere", "true");
  if (element.is("PatchTestMovementProjectiveConstraint")) setDefault(element, "velocity", "zero");
  if (element.is("AttachProjectiveConstraint")) setDefault(element, "twoWay", "false");
  if (element.is("AttachProjectiveConstraint") && moves && !isOfFrames(element))
    setQuirk(element, "moved-inertia", "meet", "halfway");
  if (element.is("AttachProjectiveConstraint") && integrator && integrator->is("StaticSolver") && !saysYes(element.text("twoWay")) &&
      !isOfFrames(element))
    warn(element.written->where, element, {}, "takes nodes to those that they follow: SOFA's go halfway there after each step of statics");
  if (element.is("AttachProjectiveConstraint") && !integrator)
    warn(element.written->where, element, {}, "ties bodies of a solver each: SOFA moves each freely and takes means after a step");
  if (holdsNothing(element)) return;
  if (element.is("FixedPlaneProjectiveConstraint")) meanSlidingPlane(element, integrator && moves && isAssembled(*integrator));
  const bool all = saysYes(element.text("fixAll"));
  if (!all && !element.find("indices") && holdsFirstNode(element.written->type) &&
      quirks_.use("first-node", element.path())) {
    warn(element.written->where, element, "indices", "is not given: SOFA holds node 0");
    element.set("indices", "0");
  }
}

/// It answers contacts by forces of constraint.
static bool answersByConstraint(const Element& each) {
  return each.text("response").find("Constraint") != std::string::npos && !each.dropped;
}

/// Contacts are those that SOFA lists: of the formulas and with the filters of its methods.
void Rewriting::listContacts(Element& response, const Element* method) {
  constexpr const char* listed[] = {"MinProximityIntersection", "LocalMinDistance", "NewProximityIntersection"};
  if (!method || has_solids_ || std::ranges::find(listed, method->written->type) == std::end(listed)) return;
  setQuirk(response, "contact-lists", "sofaLists", "true");
  tree_->forEachPlace([&](Place& place) {
    for (const auto& each : place.elements)
      if (each->is("CollisionPipeline") && std::atoi(each->text("depth").c_str()) > 0) response.set("treeDepth", each->text("depth"));
  });
}

/// SOFA looks for contacts by its trees of boxes, whose order is known.
bool Rewriting::areContactsInOrder() {
  bool has_pairs = false, has_trees = false;
  tree_->forEachPlace([&](Place& place) {
    for (const auto& each : place.elements) {
      has_pairs = has_pairs || each->is("BruteForceBroadPhase") || each->is("BruteForceDetection");
      has_trees = has_trees || each->is("BVHNarrowPhase") || each->is("BruteForceDetection");
    }
  });
  return has_pairs && has_trees;
}

/// All forces of constraint are of conditions that sweeps find as SOFA does, equal ones or contacts in its order, in one round.
bool Rewriting::areForcesSwept() {
  if (!hasForcesOfConstraint() || hasActuators()) return false;
  bool all = true;
  tree_->forEach([&all, this](Element& each) {
    const Element* state = each.place->nearest("mechanical state");
    const bool of_numbers = each.is("UniformLagrangianConstraint") && state && state->text("template").starts_with("Vec1");
    const bool is_other = each.role() == "Lagrangian constraint" && !of_numbers &&
                          !isAnyOf(each.written->type, {"BilateralLagrangianConstraint", "FixedLagrangianConstraint"});
    const bool iterates = each.role() == "integrator" && !each.dropped &&
                          (!each.is("EulerImplicitSolver") || each.text("newtonIterations") != "1" || each.find("newtonSolver"));
    const bool unordered = answersByConstraint(each) && !(saysYes(each.text("sofaLists")) && areContactsInOrder());
    all = all && !unordered && !is_other && !iterates;
  });
  return all;
}

/// What of a constraint solver its sweeps read: methods by SOFA's numbers too, and a tolerance below 0, which no sweep meets.
static void addSwept(const AttributeDescription& given, const Element& solver, Diagnostics& diagnostics, ComponentDescription& sweeps) {
  static const std::vector<std::string> methods = {"ProjectedGaussSeidel", "UnbuiltGaussSeidel", "NonsmoothNonlinearConjugateGradient"};
  AttributeDescription taken = given;
  const std::string text(trimmed(given.value)), &name = given.name;
  const std::string path = solver.path() + "." + name;
  if (text.starts_with("@") || given.typed) return sweeps.attributes.push_back(std::move(taken));
  if (name == "resolutionMethod") {
    const std::size_t number = text.size() == 1 ? std::size_t(text[0] - '0') : methods.size();
    if (number < methods.size()) taken.value = methods[number];
    if (!isAnyOf(taken.value = trimmed(taken.value), {methods[0], methods[1], methods[2]}))
      return diagnostics.warning(given.where, path, "'" + text + "' is no method: SOFA keeps " + methods[0] + ", and so does this scene",
                                 nearest(text, methods));
  }
  const bool is_count = name.starts_with("maxIt");
  if (is_count || isAnyOf(name, {"tolerance", "sor", "regularizationTerm"})) {
    const std::vector<double> numbers = writtenNumbers(text);
    if (numbers.size() != 1) return diagnostics.error(given.where, path, "'" + text + "' is no number", "a number");
    const double number = numbers[0];
    if (is_count && !(number >= 1))
      return diagnostics.error(given.where, path, "without a sweep SOFA finds no forces, and no condition holds", "1 or more");
    if (name == "sor" && !(number > 0 && number < 2))
      return diagnostics.error(given.where, path, text + " lets sweeps go away from the forces", "a number above 0 and below 2");
    if (name == "regularizationTerm" && !(number >= 0)) return diagnostics.error(given.where, path, text + " is below 0", "0 or more");
    if (name == "tolerance" && number < 0) taken.value = "0";
  }
  sweeps.attributes.push_back(std::move(taken));
}

/// The constraint solver that counts: SOFA's loop takes the first one.
const Element* Rewriting::findConstraintSolver(bool has_loop) {
  const Element* solver = nullptr;
  tree_->forEachPlace([&](Place& place) {
    for (const auto& each : place.elements) {
      if (!each->written->type.ends_with("ConstraintSolver")) continue;
      if (solver && has_loop)
        warn(each->written->where, *each, {}, "does not count: SOFA's loop takes one constraint solver, " + solver->path(),
             "one constraint solver in a scene");
      if (!solver) solver = each.get();
    }
  });
  return solver;
}

/// LCPConstraintSolver with its matrix built, without levels and limits.
static bool isPlainComplementarity(const Element& solver) {
  const auto is = [&solver](const char* name, double usual) {
    const std::string text = solver.text(name);
    return text.empty() || (text == "true" ? 1 : std::atof(text.c_str())) == usual;
  };
  return is("build_lcp", 1) && is("multi_grid", 0) && is("minW", 0) && is("maxF", 0);
}

/// Forces hold here where SOFA's search for them ends early.
void Rewriting::warnOfTolerance(const Element* solver, const Element& loop) {
  constexpr double tight = 1e-9;  // of a scene in metres or millimetres
  const std::string tolerance = solver ? solver->text("tolerance") : "";
  const bool is_swept = areForcesSwept() && (!solver || !solver->is("LCPConstraintSolver") || isPlainComplementarity(*solver));
  if (!hasForcesOfConstraint() || is_swept || (!tolerance.empty() && std::atof(tolerance.c_str()) <= tight)) return;
  bool has_contacts = false;
  tree_->forEach([&has_contacts](Element& each) { has_contacts = has_contacts || answersByConstraint(each); });
  warn(solver ? solver->written->where : scene_.root.where, solver ? *solver : loop, "tolerance",
       std::string("ends SOFA's search for forces of constraint before they hold, which depends on the order of ") +
           (has_contacts ? "contacts: here they hold. What lies on several points may differ by some hundredths of its movement"
                         : "constraints: here they hold"),
       "a tolerance of 1e-9, with which both do nearly the same");
}

/// SOFA's search for forces of constraint ends at a tolerance. Without a solver for them its loop makes one with the defaults.
void Rewriting::addSweeps() {
  const Element* loop = nullptr;
  tree_->forEachPlace([&loop](Place& place) {
    for (const auto& each : place.elements)
      if (each->written->type.ends_with("FreeMotionAnimationLoop")) loop = each.get();
  });
  const bool has_loop = loop != nullptr;
  const Element* solver = findConstraintSolver(has_loop);
  const std::string type = solver ? solver->written->type : "GenericConstraintSolver";
  bool has_conditions = false;
  tree_->forEach([&](Element& each) { has_conditions = has_conditions || each.role() == "Lagrangian constraint"; });
  if (type == "LCPConstraintSolver" && has_conditions)
    return warn(solver->written->where, *solver, {},
                "takes all conditions as contacts that may come apart: here those hold that are to hold",
                "GenericConstraintSolver, with which both do the same");
  const bool is_soft = solver && std::atof(solver->text("regularizationTerm").c_str()) != 0;
  const bool is_plain = type != "LCPConstraintSolver" || isPlainComplementarity(*solver);
  const bool counts = has_loop && areForcesSwept() && is_plain && type != "ImprovedJacobiConstraintSolver" &&
                      quirks_.use("one-iteration", solver ? solver->path() : tree_->root().path());
  const std::string method = solver ? solver->text("resolutionMethod") : "";
  const bool is_unbuilt = type.starts_with("Unbuilt") || method.starts_with("Unbuilt") || method == "1";
  if (loop) warnOfTolerance(solver, *loop);
  if (is_soft && (!counts || is_unbuilt))
    warn(solver->written->where, *solver, "regularizationTerm", "makes constraints soft in SOFA: here they hold");
  if (!counts) return;
  const SourceLocation where = solver ? solver->written->where : scene_.root.where;
  ComponentDescription sweeps{"ConstraintSweeps",
                              {{"name", "sweeps_of_constraints", where}, {"keepsUnsettled", "1", where}},
                              where,
                              scene_.root.folder};
  const char* names[] = {"maxIterations", "maxIt", "tolerance", "scaleTolerance", "allVerified", "sor", "regularizationTerm",
                         "resolutionMethod"};
  for (const std::string name : names)
    if (const AttributeDescription* given = solver ? solver->find(name) : nullptr; given && !(is_unbuilt && name == "regularizationTerm"))
      addSwept(*given, *solver, diagnostics_, sweeps);
  std::erase(no_effect_, type);
  if (!turn_tolerance_.empty()) sweeps.attributes.push_back({"turnTolerance", turn_tolerance_, where});
  if (type == "LCPConstraintSolver") {
    sweeps.attributes.push_back({"resolutionMethod", "NonlinearComplementarity", where});
    const std::string guess = solver->text("initial_guess");
    if (guess.empty() || saysYes(guess)) sweeps.attributes.push_back({"keepsContactForces", "1", where});
  }
  if (type.starts_with("Unbuilt")) sweeps.attributes.push_back({"resolutionMethod", "UnbuiltGaussSeidel", where});
  if (type.starts_with("NNCG")) sweeps.attributes.push_back({"resolutionMethod", "NonsmoothNonlinearConjugateGradient", where});
  tree_->root().added_components.push_back(std::move(sweeps));
}

}  // namespace stroma::sofa
