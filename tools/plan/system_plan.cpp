// SPDX-License-Identifier: LGPL-2.1-or-later
// The plan of a system: an item for each thing that acts, and for what could and does not.
#include <fmt/format.h>

#include <algorithm>

#include "framework/algebra/direct_solver.h"
#include "framework/mechanics/open_choices.h"
#include "framework/scene/node.h"
#include "framework/simulation/integrator.h"
#include "tools/plan/plan.h"

namespace stroma {
namespace {

std::string traitsText(const ForceTraits& traits) {
  std::string text;
  const auto say = [&text](const char* word) { text += (text.empty() ? "" : ", ") + std::string(word); };
  if (!traits.has_stiffness) {
    say("no stiffness: left out of products and matrices");
  } else {
    say(traits.constant_stiffness ? "constant stiffness: assembled once" : "stiffness changes with the shape");
    if (!traits.symmetric) say("not symmetric");
    if (!traits.exact_tangent) say("approximate tangent");
  }
  if (traits.linear) say("linear");
  if (traits.velocity_dependent) say("depends on velocity");
  if (traits.time_dependent) say("depends on time");
  if (!traits.conservative) say("not conservative");
  return text;
}

bool isTrue(const std::string& printed) { return printed == "true" || printed == "1"; }

PlanItem itemFor(std::string kind, const Component& component, PlanWhen when, std::string says) {
  return {std::move(kind), component.path(), component.type(), when, std::move(says), {}, {}};
}

/// States and masses; gravity.
void addBodies(const System& system, std::vector<PlanItem>& items) {
  for (const State* state : system.states()) {
    const char* mapped = state->firstRow() < system.independentRows() ? "" : ", mapped";
    items.push_back(itemFor("state", *state, PlanWhen::held, fmt::format("{} nodes{}", state->size(), mapped)));
    items.back().figures = {{"nodes", double(state->size())}};
  }
  for (const Mass* mass : system.masses()) {
    items.push_back(
        itemFor("mass", *mass, PlanWhen::held,
                fmt::format("{:.6g} kg, {}", mass->totalMass(), mass->isDiagonal() ? "diagonal" : "sparse matrix")));
    items.back().figures = {{"mass", mass->totalMass()}};
  }
  if (system.hasGravity())
    items.push_back({"gravity", {}, {}, PlanWhen::once, "constant force, computed once", {}, {}});
  else
    items.push_back({"gravity", {}, {}, PlanWhen::skipped, "skipped, no mass is subject to gravity", {}, {}});
}

void addForces(const System& system, std::vector<PlanItem>& items) {
  for (const ForceField* field : system.forceFields()) {
    const auto* open = dynamic_cast<const OpenChoices*>(field);
    std::string choice = open ? open->choice() : std::string();
    if (!choice.empty()) choice += ", ";
    items.push_back(itemFor("force", *field, PlanWhen::each_evaluation,
                            "each evaluation; " + choice + traitsText(field->traits())));
  }
  if (system.forceFields().empty()) items.push_back({"forces", {}, {}, PlanWhen::skipped, "none but gravity", {}, {}});
}

/// Forces of constraint that end at a tolerance of the scene's.
void addSweeps(const System& system, std::vector<PlanItem>& items) {
  const Integrator& integrator = system.integrator();
  if (system.actors().lagrangian_constraints.empty()) return;
  std::vector<Component*> all;
  integrator.node().root().collect(all);
  const auto sweeps = std::ranges::find_if(all, [](const Component* each) { return each->type() == "ConstraintSweeps"; });
  if (sweeps == all.end()) return;
  const auto valueOf = [](const Component& component, const char* name) {
    const Data* data = component.data().find(name);
    return data ? data->print() : std::string();
  };
  if (!isTrue(valueOf(integrator, "oneRound")))
    return items.push_back(itemFor("sweeps", **sweeps, PlanWhen::skipped, "skipped, " + integrator.path() + " has no oneRound"));
  const bool is_scaled = isTrue(valueOf(**sweeps, "scaleTolerance")) && !isTrue(valueOf(**sweeps, "allVerified"));
  const char* per_row = is_scaled ? " for each condition" : "";
  items.push_back(itemFor("sweeps", **sweeps, PlanWhen::each_step,
                          fmt::format("each step, constraint forces to a tolerance of {} m{}, by at most {} sweeps, if all "
                                      "conditions are equalities",
                                      valueOf(**sweeps, "tolerance"), per_row, valueOf(**sweeps, "maxIterations"))));
}

void addConstraints(const System& system, std::vector<PlanItem>& items) {
  const ConstraintSet& constraints = system.constraints();
  for (const ProjectiveConstraint* constraint : constraints.all()) {
    items.push_back(itemFor("constraint", *constraint, PlanWhen::held, {}));
    const double end = constraint->endTime();
    if (end < 0) continue;
    items.back().says = fmt::format("until t = {} s", end);
    items.back().figures = {{"end_time", end}};
  }
  if (!constraints.all().empty()) {
    const std::size_t held = constraints.projectors().size();
    const Index relations = constraints.relations().empty() ? 0 : constraints.relations().relations().count();
    std::string says = fmt::format("{} held or guided, ", held);
    if (relations > 0) says += fmt::format("{} scalar relation{}, ", relations, relations == 1 ? "" : "s");
    const bool changes = bool(constraints.change());
    items.push_back({"nodes",
                     {},
                     {},
                     changes ? PlanWhen::each_step : PlanWhen::once,
                     says + (changes ? "looked up at each step" : "looked up once"),
                     {{"nodes", double(held)}, {"relations", double(relations)}},
                     {}});
  }
  for (const LagrangianConstraint* constraint : system.actors().lagrangian_constraints) {
    const auto* open = dynamic_cast<const OpenChoices*>(constraint);
    const std::string choice = open ? open->choice() : std::string();
    items.push_back(itemFor("constraint", dynamic_cast<const Component&>(*constraint), PlanWhen::each_step,
                            "each step, by constraint forces" + (choice.empty() ? choice : "; " + choice)));
  }
  addSweeps(system, items);
  for (const PositionConstraint* constraint : system.actors().position_constraints)
    items.push_back(itemFor("position constraint", *constraint, PlanWhen::after_each_step,
                            "after each step; " + constraint->describe()));
}

void addMappings(const System& system, std::vector<PlanItem>& items) {
  const auto& acting = system.actors().mappings;
  const auto& passive = system.actors().passive_mappings;
  for (const Mapping* mapping : acting)
    items.push_back(itemFor("mapping", *mapping, PlanWhen::each_evaluation, "each evaluation"));
  for (const Mapping* mapping : passive)
    items.push_back(
        itemFor("mapping", *mapping, PlanWhen::after_each_step, "only after steps in which it is read; nothing acts on its nodes"));
  if (acting.empty() && passive.empty())
    items.push_back({"mappings", {}, {}, PlanWhen::skipped, "none, skipped", {}, {}});
}

/// Linear solvers beside the integrators of a system that do not solve for it.
void addIdleSolvers(const System& system, std::vector<PlanItem>& items) {
  std::vector<const Integrator*> integrators{&system.integrator()};
  for (const MergedIntegrator& merged : system.merged()) integrators.push_back(merged.integrator);
  const auto add = [&](const LinearSolver& solver, const Node& node) {
    const Component* user = nullptr;
    for (const auto& other : node.components())
      if (const auto* taker = dynamic_cast<const FactorUser*>(other.get()); taker && taker->usesFactorOf(solver))
        user = other.get();
    const LinearSolver* const used = system.linearSolver();
    items.push_back(
        user ? itemFor("linear solver", solver, PlanWhen::each_step, fmt::format("its factors serve {}", user->path()))
             : itemFor("linear solver", solver, PlanWhen::skipped,
                       used ? fmt::format("skipped, {} solves for this system", used->path())
                            : fmt::format("skipped, {} solves no linear systems", system.integrator().path())));
  };
  for (const Integrator* integrator : integrators)
    for (const auto& component : integrator->node().components())
      if (const auto* solver = dynamic_cast<const LinearSolver*>(component.get());
          solver && solver != system.linearSolver())
        add(*solver, integrator->node());
}

void addSolvers(const System& system, std::vector<PlanItem>& items) {
  const Integrator& integrator = system.integrator();
  items.push_back(itemFor("integrator", integrator, PlanWhen::each_step, integrator.describe()));
  for (const MergedIntegrator& merged : system.merged())
    items.push_back(itemFor(
        "integrator", *merged.integrator, PlanWhen::skipped,
        fmt::format("skipped, its bodies belong to this system because {} couples them to others", merged.because)));
  const LinearSolver* solver = system.linearSolver();
  if (!solver) {
    items.push_back({"linear solver", {}, {}, PlanWhen::skipped, "none", {}, {}});
    return addIdleSolvers(system, items);
  }
  const long blocks = long(system.matrix().keptBlocks());
  items.push_back(itemFor(
      "linear solver", *solver, PlanWhen::each_step,
      blocks >= 0 ? fmt::format("matrix of {} blocks of 3x3", blocks) : std::string("no matrix is kept so far")));
  if (blocks >= 0) items.back().figures = {{"blocks", double(blocks)}};
  if (const std::string choice = choiceOf(*solver); !choice.empty()) items.back().says += "; " + choice;
  if (const Data* precision = solver->data().find("factorPrecision"))
    items.back().says += "; precision of factors: " + precision->print();
  if (solver->isMadeForAnother())
    items.back().note = "created with its defaults because the scene has none";
  addIdleSolvers(system, items);
}

}  // namespace

std::string choiceOf(const LinearSolver& solver) {
  const Data* choice = solver.data().find("choice");
  const auto* text = choice ? std::get_if<std::string*>(&choice->pointer()) : nullptr;
  return text ? **text : std::string();
}

SystemPlan planOf(const System& system) {
  SystemPlan plan{system.integrator().path(), system.allRows(), system.independentRows(), {}};
  addBodies(system, plan.items);
  addForces(system, plan.items);
  addConstraints(system, plan.items);
  addMappings(system, plan.items);
  addSolvers(system, plan.items);
  return plan;
}

}  // namespace stroma
