// SPDX-License-Identifier: LGPL-2.1-or-later
// The net forces of the present state, and what Lagrangian constraints did in the last step: the sum of their gradients times the
// forces that they tell. After a checkpoint has been restored not all of them have the gradients of the step before it, nor a
// contact its pairs, so that a checkpoint of Python has both forces.
#include <algorithm>
#include <cmath>

#include "framework/mechanics/lagrangian_constraint.h"
#include "framework/simulation/integrator.h"
#include "framework/simulation/step_limits.h"
#include "tools/python/engine.h"

namespace stroma::python {
namespace {

/// Forces of constraint of a component in the last step, as it tells them itself; none before a step.
const std::vector<double>& toldForces(const Component& component) {
  const DataTable& table = component.data();
  const Data* data = table.find("multipliers") ? table.find("multipliers") : table.find("forces");
  const auto* const* found = data ? std::get_if<std::vector<double>*>(&data->pointer()) : nullptr;
  if (!found)
    throw ComponentError(component.path() + " does not tell the forces of its conditions", "its own attributes of forces");
  return **found;
}

/// The same, one for each of its rows.
std::vector<double> multipliersOf(const Component& component, const std::vector<double>& given,
                                  const std::vector<LagrangianRows::Row>& rows) {
  std::vector<double> forces(rows.size(), 0);
  if (given.size() == rows.size())
    forces = given;
  else if (given.size() == 1 && !rows.empty())
    forces[0] = given[0];  // of rows that are one another or its opposite
  else
    throw ComponentError(component.path() + " has not the conditions of the last step any more", "a step before");
  if (given.size() == 1 && rows.size() > 0 && rows[0].kind == LagrangianRows::Kind::push) forces[0] = std::abs(forces[0]);
  return forces;
}

}  // namespace

Vector Engine::constraintForces(std::size_t index) const {
  const System& system = *use().systems()[index];
  const auto& constraints = system.actors().lagrangian_constraints;
  Vector all(constraints.empty() ? 0 : system.allRows());
  if (all.count() > 0 && index < restored_.size() && restored_[index].count() == all.count()) {
    stroma::copy(restored_[index], all);
    return all;
  }
  if (constraints.empty()) return all;
  const ConstRows x = system.mappingChain().positions(system.x);
  for (const LagrangianConstraint* constraint : constraints) {
    const auto& component = dynamic_cast<const Component&>(*constraint);
    const std::vector<double>& told = toldForces(component);
    if (told.empty()) continue;
    LagrangianRows rows;
    constraint->addConditions(x, x, rows);
    const std::vector<double> forces = multipliersOf(component, told, rows.rows());
    for (std::size_t i = 0; i < forces.size(); ++i)
      for (const auto& [row, gradient] : rows.entriesOf(rows.rows()[i])) all[row] += forces[i] * gradient;
  }
  return all;
}

void Engine::requestForces() {
  for (const auto& system : between().systems())
    if (system->integrator().stateOwner())
      throw ComponentError("forces cannot be asked for: " + system->integrator().path() + " has computed its matrix beforehand",
                           "its dragForces, which are those on nodes that are moved");
  if (!keeps_forces_) forcesAreOld();
  keeps_forces_ = true;
  for (State* state : simulation_->states()) state->requestForce();
}

void Engine::presentForces() {
  if (!keeps_forces_ || use().isStepping() || simulation_->steps() != old_at_) return;
  if (!own_) return;  // the command's: a step computes them
  const Systems& systems = twin().simulation().systems();
  for (std::size_t i = 0; i < systems.size(); ++i) {
    System& system = *systems[i];
    system.setTime(simulation_->time());
    tellStepBegins(system, system.x, simulation_->time(), simulation_->time() + simulation_->dt());  // contacts find their pairs
    system.computeForce(system.x, system.v, system.f);
    stroma::copy(system.f, simulation_->systems()[i]->f);
  }
  old_at_ = -1;
}

Checkpoint Engine::checkpoint() {
  Checkpoint checkpoint = session_.checkpoint();
  if (keeps_forces_ && simulation_->steps() != old_at_) {
    checkpoint.values.enter("forces");
    for (std::size_t i = 0; i < simulation_->systems().size(); ++i)
      checkpoint.values.rows(std::to_string(i), simulation_->systems()[i]->f);
  }
  std::vector<Vector> forces;
  try {
    for (std::size_t i = 0; i < simulation_->systems().size(); ++i) forces.push_back(constraintForces(i));
  } catch (const ComponentError&) {  // who asks for them is told
    return checkpoint;
  }
  checkpoint.values.enter("constraint forces");
  for (std::size_t i = 0; i < forces.size(); ++i)
    if (forces[i].count() > 0) checkpoint.values.rows(std::to_string(i), forces[i]);
  return checkpoint;
}

std::vector<std::string> Engine::restore(Checkpoint checkpoint) {
  Archive forces = checkpoint.values.take("constraint forces"), net = checkpoint.values.take("forces");
  std::vector<std::string> notes = session_.restore(std::move(checkpoint), "the checkpoint");
  forcesAreOld();
  for (std::size_t i = 0; keeps_forces_ && i < simulation_->systems().size(); ++i)
    if (const std::string name = std::to_string(i); net.entries().count("forces:" + name) > 0) {
      net.rows(name, simulation_->systems()[i]->f);
      old_at_ = -1;
    }
  restored_ = std::vector<Vector>(simulation_->systems().size());
  for (std::size_t i = 0; i < restored_.size(); ++i)
    if (const std::string name = std::to_string(i); forces.entries().count("constraint forces:" + name) > 0)
      forces.rows(name, restored_[i]);
  return notes;
}

}  // namespace stroma::python
