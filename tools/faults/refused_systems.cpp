// SPDX-License-Identifier: LGPL-2.1-or-later
// What one system refuses: parts of it that do not fit each other.
#include <fmt/format.h>

#include <algorithm>

#include "framework/mechanics/right_side.h"
#include "framework/scene/usual_component.h"
#include "framework/simulation/integrator.h"
#include "framework/simulation/refusals.h"
#include "framework/simulation/step_limits.h"

namespace stroma {

namespace {

void checkSecondMasses(const std::vector<Mass*>& masses) {
  const auto isNamed = [](const Mass* mass) { return mass->data().find("mstate")->isSet(); };  // not one that is there by oversight
  for (std::size_t i = 0; i < masses.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      if (&masses[i]->state() != &masses[j]->state()) continue;
      if (!isNamed(masses[i]) && !isNamed(masses[j]))
        throw ComponentError(fmt::format("{} has two masses: {} and {}", masses[i]->state().path(), masses[j]->path(), masses[i]->path()),
                             "one of them, or mstate=\"@" + masses[i]->state().path() + "\" of the second where they add up");
      masses[i]->warn(fmt::format("{} has the mass of {} too: they add up", masses[i]->state().path(), masses[j]->path()));
    }
}

void checkMapping(const Actors& actors, std::size_t index) {
  const Mapping& mapping = *actors.mappings[index];
  for (std::size_t j = 0; j < index; ++j)
    if (&mapping.output() == &actors.mappings[j]->output())
      throw ComponentError(
          fmt::format("two mappings move {}: {} and {}", mapping.output().path(), actors.mappings[j]->path(), mapping.path()),
          "one mapping per state");
  for (const ProjectiveConstraint* constraint : actors.constraints)
    if (const std::vector<State*> states = constraint->states(); std::ranges::find(states, &mapping.output()) != states.end())
      throw ComponentError(fmt::format("{} constrains nodes of {}, whose positions are mapped from {} by {}", constraint->path(),
                                       mapping.output().path(), mapping.input().path(), mapping.path()),
                           "constraints on the state that is mapped from");
}

}  // namespace

void checkActors(const Actors& actors) {
  checkSecondMasses(actors.masses);
  for (std::size_t i = 0; i < actors.mappings.size(); ++i) checkMapping(actors, i);
}

void checkPositionConstraints(const Actors& actors, const Integrator& integrator, const ConstraintSet& constraints) {
  if (!integrator.movesInTime())
    throw ComponentError(fmt::format("{} finds an equilibrium, but {} acts on motion", integrator.path(),
                                     actors.position_constraints.front()->path()),
                         "a dynamic integrator, or no position constraint");
  for (const PositionConstraint* constraint : actors.position_constraints)
    if (constraint->state().firstRow() >= actors.independent_rows)
      throw ComponentError(fmt::format("{} acts on {}, whose positions follow from another state by a mapping",
                                       constraint->path(), constraint->state().path()),
                           "position constraints on the state that is mapped from");
  for (const PositionConstraint* constraint : actors.position_constraints)
    if (!constraint->state().hasPointsOnly() && !(constraint->state().hasFrames() && constraint->takesFrames()))
      throw ComponentError(fmt::format("{} acts on points, and {} has {}", constraint->path(), constraint->state().path(),
                                       constraint->state().hasFrames() ? "rigid frames" : "numbers"),
                           "position constraints on a state of points");
  if (!constraints.relations().empty())
    throw ComponentError(fmt::format("{} corrects positions after each step, and the corrections would violate relations between "
                                     "displacements", actors.position_constraints.front()->path()),
                         "position constraints, or linear relations");
}

void checkMassesUnderMotion(const Actors& actors) {
  const auto moving = std::find_if(actors.constraints.begin(), actors.constraints.end(),
                                   [](const ProjectiveConstraint* c) { return c->prescribesMotion(); });
  const auto alone = [&actors](const Mass* mass) {
    return mass->leavesMovedAlone() || (mass->isDiagonal() && mass->state().firstRow() < actors.independent_rows);
  };
  if (moving != actors.constraints.end() && !std::all_of(actors.masses.begin(), actors.masses.end(), alone))
    throw ComponentError(
        (*moving)->path() + " moves nodes, and their inertia would not act on their neighbours through a non-diagonal mass",
        "a diagonal mass", "use " + usualComponent(Part::diagonal_mass) + ", or lumping=\"true\"");
}

void checkMassOf(const State& state, const Actors& actors, const std::vector<char>& held, const std::vector<double>& mass) {
  const bool has_mass = std::any_of(actors.masses.begin(), actors.masses.end(), [&state](const Mass* m) { return &m->state() == &state; });
  for (Index i = 0; i < state.size(); ++i) {
    const std::size_t row = std::size_t(state.firstRow() + i);
    if (held[row] || mass[row] > 0) continue;
    if (!has_mass)
      throw ComponentError(fmt::format("{} has no mass, so its motion is not defined", state.path()), "a mass in the state's node",
                           "add <" + usualComponent(Part::mass) + " totalMass=\"1\"/>");
    throw ComponentError(fmt::format("node {} of {} has a mass of {} kg, so its motion is not defined", i, state.path(), mass[row]),
                         "a positive mass at every node that is not held");
  }
}

/// What ends with its component cannot be told from what an integrator knows of a body (turning inertia), and a sum of
/// turns is none.
void ConstraintSet::refuseTurningRows() const {
  const auto kindOf = [this](Index row) { return actors_.motion.kindOf(row); };
  for (const ProjectiveConstraint* constraint : all()) {
    std::vector<Tie> ties;
    LinearRelations relations;
    constraint->addTies(ties);
    constraint->addRelations(relations);
    for (const LinearRelations::Term& term : relations.terms)
      if (kindOf(term.row) == RowKind::turn)
        throw ComponentError(
            fmt::format("{} relates displacements, and {} is an orientation", constraint->path(), actors_.describeRow(term.row)),
            "relations of points, centres of frames or numbers");
    for (const Tie& tie : ties) {
      if (kindOf(tie.a) != kindOf(tie.b))
        throw ComponentError(fmt::format("{} ties {} and {}, which are of different types", constraint->path(),
                                         actors_.describeRow(tie.a), actors_.describeRow(tie.b)),
                             "nodes of one type, or points and the centres of frames");
      if (kindOf(tie.a) == RowKind::turn && constraint->endTime() >= 0)
        throw ComponentError(fmt::format("{} ties orientations and ends", constraint->path()), "no endTime");
    }
  }
}

void checkStepLimits(const System& system) {
  const auto& lagrangian = system.actors().lagrangian_constraints;
  if (!lagrangian.empty() && !dynamic_cast<const FindsMultipliers*>(&system.integrator()))
    throw ComponentError(fmt::format("{} does not support the constraint {}", system.integrator().type(),
                                     dynamic_cast<const Component&>(*lagrangian.front()).path()),
                         "an integrator that does: " + usualComponent(Part::integrator));
  for (const ProjectiveConstraint* constraint : system.constraints().all())
    if (const auto* side = dynamic_cast<const ProjectsRightSide*>(constraint);
        side && side->leavesMatrix() && !dynamic_cast<const AsksRightSides*>(&system.integrator()))
      throw ComponentError(
          fmt::format("{} has inMatrix=\"false\", and {} does not project the right side", constraint->path(), system.integrator().type()),
          usualComponent(Part::integrator) + ", or no inMatrix");
  const auto& fields = system.forceFields();
  const auto limiter = std::find_if(fields.begin(), fields.end(), [](ForceField* f) { return dynamic_cast<StepLimiter*>(f) != nullptr; });
  if (limiter == fields.end()) return;
  const std::string path = (*limiter)->path();
  const auto* heeds = dynamic_cast<const RespectsStepLimits*>(&system.integrator());
  if (!heeds || !heeds->respectsStepLimits())
    throw ComponentError(fmt::format("{} moves bodies without asking {} how far they may move before they pass through each other",
                                     system.integrator().type(), path),
                         "an implicit integrator or statics with Newton's method", heeds ? heeds->howToRespectStepLimits() : "");
  if (!system.actors().position_constraints.empty())
    throw ComponentError(fmt::format("{} moves positions after the step, where {} cannot prevent penetration",
                                     system.actors().position_constraints.front()->path(), path),
                         "contact or position constraints, not both");
  for (ForceField* field : fields)
    if (auto* each = dynamic_cast<StepLimiter*>(field)) each->checkStart(system.x);
}

void System::checkLinearSolver() const {
  const LinearSolver* solver = linearSolver();
  if (!solver) return;
  if (const Index most = solver->mostRows(); independentRows() > most)
    throw ComponentError(
        fmt::format("{} nodes are too many for the dense matrix of {}", independentRows(), solver->path()),
        fmt::format("at most {} nodes", most), usualComponent(Part::solver_of_equilibria));
  if (!solver->needsSymmetric() || matrix_.symmetric()) return;
  for (const ForceField* field : forceFields())
    if (const ForceTraits traits = field->traits();
        !traits.symmetric && (traits.has_stiffness || traits.velocity_dependent))
      throw ComponentError(fmt::format("{} solves symmetric systems only, and the derivative of {} is not symmetric",
                                       solver->path(), field->path()),
                           "a solver for unsymmetric matrices");
}

}  // namespace stroma
