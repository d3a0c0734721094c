// SPDX-License-Identifier: LGPL-2.1-or-later
// What the other bodies are (the steps: other_bodies_steps.cpp).
#include "components/condensation/other_bodies.h"

#include <fmt/format.h>

#include <algorithm>

#include "framework/mechanics/lagrangian_constraint.h"
#include "framework/mechanics/step_limiter.h"
#include "framework/scene/node.h"
#include "framework/simulation/input_forces.h"

namespace stroma {
namespace {

bool isBelow(const Node& node, const Node& above) {
  for (const Node* at = &node; at; at = at->parent())
    if (at == &above) return true;
  return false;
}

/// Of another integrator than the condensed solver.
const Integrator* otherIntegrator(const State& state, const System& system) {
  for (const MergedIntegrator& merged : system.merged())
    if (!merged.integrator->stateOwner() && isBelow(state.node(), merged.integrator->node())) return merged.integrator;
  return nullptr;
}

}  // namespace

bool OtherBodies::has(const State& state) const { return std::ranges::find(states_, &state) != states_.end(); }

bool OtherBodies::has(const Component& component) const {
  const std::vector<State*> states = statesActedOn(component);
  return std::ranges::any_of(states, [this](const State* state) { return has(*state); });
}

void OtherBodies::collect(System& system, const Integrator& integrator, double rayleigh_mass) {
  rayleigh_mass_ = rayleigh_mass;
  states_.clear(), rows_.clear(), is_other_.clear(), number_.clear(), solvers_.clear(), clusters_.clear();
  collectStates(system);
  if (states_.empty()) return;
  is_static_ = !integrator.movesInTime();
  collectActing(system, integrator);
  collectMappings();
  collectTurning();
  for (auto* vectors : {&kept_velocity_, &start_velocity_, &free_change_, &now_}) vectors->assign(rows_.size(), Vec3::Zero());
  start_.assign(rows_.size(), {}), start_turn_.assign(rows_.size(), Quaternion::Identity());
  projectors_.assign(rows_.size(), Mat3::Identity());
  force_.resize(system.allRows());
  gravity_.assign(rows_.size(), Vec3::Zero());
  clear(force_);
  for (const Mass* mass : masses_)
    if (!mass->node().gravity().isZero(0)) mass->addGravity(force_);
  for (std::size_t k = 0; k < rows_.size(); ++k) gravity_[k] = force_[rows_[k]];
  checkHeld(system, integrator), checkSolvers();
  compileFields(system), makeClusters(system);
}

void OtherBodies::collectStates(System& system) {
  for (const State* state : system.states()) {
    if (state->firstRow() >= system.independentRows()) break;
    const Integrator* other = otherIntegrator(*state, system);
    if (!other && !state->hasFrames()) continue;
    states_.push_back(state);
    if (!state->hasFrames()) solvers_.emplace_back(state, other->linearSolver());
  }
  if (states_.empty()) return;
  is_other_.assign(std::size_t(system.allRows()), 0), number_.assign(std::size_t(system.independentRows()), -1);
  const auto add = [this](const State& state) {
    std::fill_n(is_other_.begin() + state.firstRow(), state.size(), char(1));
  };
  for (const State* state : states_) {
    add(*state);
    for (Index i = 0; i < state->size(); ++i) {
      number_[std::size_t(state->firstRow() + i)] = Index(rows_.size());
      rows_.push_back(state->firstRow() + i);
    }
  }
  mappings_.clear();
  for (Mapping* mapping : system.actors().mappings) {  // parents first
    const std::vector<State*> inputs = mapping->inputs();
    if (!std::ranges::all_of(inputs, [this](const State* input) { return has(*input); })) continue;
    mappings_.push_back(mapping), states_.push_back(&mapping->output()), add(mapping->output());
  }
}

/// A force between both kinds would be a part of the constant matrix.
void OtherBodies::refuseMixed(const Component& component, const std::vector<State*>& states, const Integrator& integrator) const {
  const auto here = std::ranges::find_if(states, [this](const State* state) { return has(*state); });
  const auto there = std::ranges::find_if(states, [this](const State* state) { return !has(*state); });
  if (dynamic_cast<const StepListener*>(&component))
    throw ComponentError(fmt::format("{} acts on {}, a body beside those that {} condenses: these meet by constraint forces only",
                                     component.path(), (*here)->path(), integrator.path()),
                         "contact by constraint forces", "<ConstraintContact/> in its place");
  if (there != states.end())
    throw ComponentError(fmt::format("{} acts on {} and on {}, which {} condenses: its stiffness would change the stored inverse",
                                     component.path(), (*here)->path(), (*there)->path(), integrator.path()),
                         "constraint forces between the two", "a Lagrangian constraint such as <BilateralLagrangianConstraint/>");
}

void OtherBodies::collectActing(System& system, const Integrator& integrator) {
  fields_.clear(), masses_.clear();
  for (ForceField* field : system.forceFields()) {
    if (!has(*field) || field == system.inputs()) continue;
    if (dynamic_cast<const LagrangianConstraint*>(field) && !field->traits().has_stiffness) continue;  // its conditions act
    refuseMixed(*field, field->states(), integrator);
    fields_.push_back(field);
  }
  for (Mass* mass : system.masses()) {
    if (!has(mass->state())) continue;
    if (mass->state().firstRow() >= system.independentRows())
      throw ComponentError(fmt::format("{} is on mapped nodes of a body that {} moves", mass->path(), integrator.path()),
                           "the mass of the nodes mapped from, and the inertia of frames");
    masses_.push_back(mass);
  }
  has_constraints_ = std::ranges::any_of(system.constraints().all(), [this](const ProjectiveConstraint* each) { return has(*each); });
  for (const MergedIntegrator& merged : system.merged())
    for (const char* name : {"rayleighMass", "rayleighStiffness", "vdamping", "velocityThreshold"})
      if (const Data* data = merged.integrator->data().find(name);
          data && !merged.integrator->stateOwner() && data->print() != "0" && data->print() != "false")
        throw ComponentError(fmt::format("{} has {}=\"{}\", and {} moves its bodies", merged.integrator->path(), name, data->print(),
                                         integrator.path()),
                             "damping of the force fields and masses of these bodies");
}

void OtherBodies::checkHeld(const System& system, const Integrator& integrator) const {
  std::vector<double> mass(std::size_t(system.allRows()), 0.0);
  for (const Mass* each : masses_)
    for (Index i = 0; i < each->state().size(); ++i) mass[std::size_t(each->state().firstRow() + i)] += each->lumped()[std::size_t(i)];
  for (const Index row : rows_) {
    const Mat3 free = projector(system, number_[std::size_t(row)]);
    if (free.isZero(0)) continue;
    const std::string node = system.actors().describeRow(row);
    if (is_static_)
      throw ComponentError(fmt::format("{} is free, and {} finds an equilibrium of condensed bodies only", node, integrator.path()),
                           "frames that are held or moved on a path", "<CondensedDynamicSolver/> moves free ones");
    if (!(mass[std::size_t(row)] > 0))
      throw ComponentError(fmt::format("{} has no mass, so its motion is not defined", node), "a mass, and an inertia of frames",
                           "<UniformMass totalMass=\"...\" inertia=\"...\"/>");
  }
}

/// The blocks of a Jacobian come in the same order each time.
void OtherBodies::collectMappings() {
  blocks_.assign(mappings_.size(), {});
  order_.clear(), of_row_.assign(is_other_.size() - number_.size(), {});
  for (std::size_t m = 0; m < mappings_.size(); ++m) {
    mappings_[m]->addJacobian(blocks_[m]);
    for (std::size_t i = 0; i < blocks_[m].size(); ++i) order_.push_back({m, i});
  }
  const auto childOf = [this](const std::array<std::size_t, 2>& each) { return blocks_[each[0]][each[1]].child; };
  std::ranges::stable_sort(order_, {}, childOf);
  for (std::size_t i = 0; i < order_.size(); ++i) {
    Place& place = of_row_[std::size_t(childOf(order_[i])) - number_.size()];
    if (place.end == 0) place.begin = i;
    place.end = i + 1;
  }
  outdated_ = true;
}

void OtherBodies::collectTurning() {
  turning_.clear(), turning_of_.assign(rows_.size(), -1), has_inertia_turns_ = false;
  for (const Mass* mass : masses_)
    for (const TurningInertia& inertia : mass->turningInertias()) {
      const Index row = mass->state().firstRow() + inertia.row;
      int& turning = turning_of_[std::size_t(number_[std::size_t(row)])];
      if (turning < 0) {
        turning = int(turning_.size());
        double mean = 0;
        for (const Mass* each : masses_)
          if (const Index local = row - each->state().firstRow(); local >= 0 && local < each->state().size())
            mean += each->lumped()[std::size_t(local)];
        turning_.push_back({mean * Mat3::Identity(), inertia.turns});
      }
      turning_[std::size_t(turning)].inertia += inertia.inertia - inertia.inertia.trace() / 3 * Mat3::Identity();
      has_inertia_turns_ = has_inertia_turns_ || inertia.turns;
    }
}

std::string OtherBodies::describe() const {
  Index soft = 0;
  for (const auto& [state, solver] : solvers_) soft += state->size();
  const Index frames = (count() - soft) / 2;
  std::string text = frames > 0 ? fmt::format("{} rigid frame{}", frames, frames == 1 ? "" : "s") : "";
  if (soft > 0) text += fmt::format("{}{} nodes of soft bodies", text.empty() ? "" : " and ", soft);
  return fmt::format("; {} beside the condensed bodies, by backward Euler with one linear solve", text);
}

}  // namespace stroma
