// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/simulation/actors.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "framework/scene/node.h"
#include "framework/scene/usual_component.h"
#include "framework/simulation/integrator.h"
#include "framework/simulation/refusals.h"

namespace stroma {

namespace {

bool contains(const std::vector<State*>& states, const State* state) {
  return std::find(states.begin(), states.end(), state) != states.end();
}

// A mapping comes after the one that places its input.
void orderMappings(std::vector<Mapping*>& mappings) {
  std::vector<Mapping*> waiting = std::move(mappings);
  mappings.clear();
  while (!waiting.empty()) {
    const auto ready = std::find_if(waiting.begin(), waiting.end(), [&waiting](const Mapping* mapping) {
      const std::vector<State*> inputs = mapping->inputs();
      return std::none_of(waiting.begin(), waiting.end(), [&inputs](const Mapping* other) { return contains(inputs, &other->output()); });
    });
    if (ready == waiting.end())
      throw ComponentError(
          fmt::format("the mappings go in a circle: {} needs the output of another one that waits for it", waiting.front()->path()),
          "mappings from parents to children");
    mappings.push_back(*ready);
    waiting.erase(ready);
  }
}

bool somethingActsOn(const Actors& actors, const State* state) {
  const auto acts = [state](const auto* actor) { return contains(statesActedOn(*actor), state); };
  return std::any_of(actors.force_fields.begin(), actors.force_fields.end(), acts) ||
         std::any_of(actors.masses.begin(), actors.masses.end(), acts) ||
         std::any_of(actors.position_constraints.begin(), actors.position_constraints.end(), acts) ||
         std::any_of(actors.lagrangian_constraints.begin(), actors.lagrangian_constraints.end(),
                     [state](const auto* each) { return contains(each->constrainedStates(), state); });
}

/// What links of force fields and constraints name: they may read it in a step without acting on it.
std::vector<const Component*> readInSteps(const Node& root) {
  std::vector<Component*> components;
  root.collect(components);
  std::vector<const Component*> read;
  for (const Component* component : components)
    if (dynamic_cast<const ForceField*>(component) || dynamic_cast<const ProjectiveConstraint*>(component))
      for (const Data& attribute : component->data().all())
        if (attribute.link() && attribute.link()->target()) read.push_back(attribute.link()->target());
  return read;
}

// From the last to the first: a child that only places passive children is passive.
void findPassiveMappings(Actors& actors) {
  if (actors.mappings.empty()) return;
  std::vector<Mapping*> acting, passive;
  const std::vector<const Component*> read = readInSteps(actors.mappings.front()->node().root());
  for (auto mapping = actors.mappings.rbegin(); mapping != actors.mappings.rend(); ++mapping) {
    const State* child = &(*mapping)->output();
    const bool feeds = std::any_of(acting.begin(), acting.end(), [&](const Mapping* m) { return contains(m->inputs(), child); });
    const bool is_read = std::find(read.begin(), read.end(), child) != read.end();
    (feeds || is_read || somethingActsOn(actors, child) ? acting : passive).push_back(*mapping);
  }
  actors.mappings.assign(acting.rbegin(), acting.rend());
  actors.passive_mappings.assign(passive.rbegin(), passive.rend());
}

void orderStates(Actors& actors) {
  std::vector<State*> mapped;
  for (const auto* mappings : {&actors.mappings, &actors.passive_mappings})
    for (const Mapping* mapping : *mappings) mapped.push_back(&mapping->output());
  std::erase_if(actors.states, [&mapped](const State* state) { return contains(mapped, state); });
  const std::size_t independent = actors.states.size();
  actors.states.insert(actors.states.end(), mapped.begin(), mapped.end());
  std::int64_t rows = 0;
  for (std::size_t i = 0; i < actors.states.size(); ++i) {
    rows += actors.states[i]->size();
    if (i < independent) actors.independent_rows = Index(rows);
    if (rows > std::numeric_limits<Index>::max() / 9)
      throw ComponentError(fmt::format("{} nodes below one integrator are more than a 32-bit index can count", rows));
  }
  actors.all_rows = Index(rows);
}

}  // namespace

Actors collectActors(const SystemMembers& members) {
  Actors actors;
  const auto pick = [&members]<class Role>(std::vector<Role*>& out) {
    for (Component* component : members.acting)
      if (auto* role = dynamic_cast<Role*>(component)) out.push_back(role);
  };
  pick(actors.states), pick(actors.force_fields), pick(actors.masses), pick(actors.constraints);
  pick(actors.position_constraints), pick(actors.lagrangian_constraints), pick(actors.mappings);
  std::erase_if(actors.lagrangian_constraints, [](const auto* each) { return each->constrainedStates().empty(); });
  if (actors.states.empty())
    throw ComponentError(
        fmt::format("there is no mechanical state in {} or below, so it has nothing to move", members.integrator->node().path()),
        "a " + usualComponent(Part::state) + " in the integrator's node or below");
  checkActors(actors);
  orderMappings(actors.mappings);
  findPassiveMappings(actors);
  orderStates(actors);
  return actors;
}

void compileActors(Actors& actors) {
  actors.motion.compile(actors.states);
  for (Mass* mass : actors.masses) mass->compile();
  for (ForceField* field : actors.force_fields) field->compile();
  for (const auto* mappings : {&actors.mappings, &actors.passive_mappings})
    for (Mapping* mapping : *mappings) mapping->compile();
  sortByTraits(actors);
}

void sortByTraits(Actors& actors) {
  for (auto* list : {&actors.stiff_fields, &actors.damped_fields, &actors.timed_fields}) list->clear();
  actors.derivatives_vary = false;
  for (ForceField* field : actors.force_fields) {
    const ForceTraits traits = field->traits();
    if (traits.velocity_dependent) actors.damped_fields.push_back(field);
    if (traits.time_dependent) actors.timed_fields.push_back(field);
    if (traits.has_stiffness) actors.stiff_fields.push_back(field);
    if (traits.velocity_dependent || (traits.has_stiffness && !traits.constant_stiffness)) actors.derivatives_vary = true;
  }
  for (const Mapping* mapping : actors.mappings)
    if (!mapping->isLinear()) actors.derivatives_vary = true;
  for (const Mass* mass : actors.masses)
    if (mass->turns()) actors.derivatives_vary = true;
}

long Actors::patternRevision() const {
  long sum = 0;
  for (const ForceField* field : force_fields) sum += field->patternRevision();
  return sum;
}

bool Actors::massTurns() const { return std::any_of(masses.begin(), masses.end(), [](const Mass* mass) { return mass->turns(); }); }

bool Actors::massIsDiagonal() const {
  const auto on_mapped = [this](const Mass* mass) { return mass->state().firstRow() >= independent_rows; };
  return std::all_of(masses.begin(), masses.end(), [&on_mapped](const Mass* mass) { return mass->isDiagonal() && !on_mapped(mass); });
}

std::string Actors::describeRow(Index row) const {
  for (const State* state : states)
    if (row >= state->firstRow() && row < state->firstRow() + state->size())
      return fmt::format("{}node {} of {}", state->kindOf(row - state->firstRow()) == RowKind::turn ? "the turn of " : "",
                         (row - state->firstRow()) / state->rows_per_node, state->path());
  return fmt::format("row {} of no state", row);
}

}  // namespace stroma
