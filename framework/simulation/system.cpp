// SPDX-License-Identifier: LGPL-2.1-or-later
// A system: what it collects, how it lays out the unknowns, and the forces on them.
#include "framework/simulation/system.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cstring>
#include <limits>
#include <utility>

#include "framework/scene/node.h"
#include "framework/simulation/integrator.h"

namespace stroma {

System::System(Node& node, Integrator& integrator) : node_(node), integrator_(integrator) {
  collect();
  checkActors();
  orderMappings();
  layOut();
  for (Mass* mass : masses_) mass->compile();
  for (ForceField* field : force_fields_) field->compile();
  for (const auto* mappings : {&mappings_, &passive_mappings_})
    for (Mapping* mapping : *mappings) mapping->compile();
  for (ForceField* field : force_fields_) {
    const ForceTraits traits = field->traits();
    if (traits.velocity_dependent) damped_fields_.push_back(field);
    if (traits.time_dependent) timed_fields_.push_back(field);
    stiffness_varies_ = stiffness_varies_ || traits.velocity_dependent;
    if (!traits.has_stiffness) continue;
    stiff_fields_.push_back(field);
    stiffness_varies_ = stiffness_varies_ || !traits.constant_stiffness;
  }
  for (const Mapping* mapping : mappings_) mappings_linear_ = mappings_linear_ && mapping->isLinear();
  stiffness_varies_ = stiffness_varies_ || !mappings_linear_;
  if (!mappings_linear_) last_force_.resize(all_rows_);
  for (const ProjectiveConstraint* constraint : constraints_)
    constraints_change_ = constraints_change_ || !constraint->isConstant() || constraint->endTime() >= 0;

  const double start = node_.root().root_time;
  reserveConstraints();
  for (const ProjectiveConstraint* constraint : constraints_) constraint->placeStart(start, x, v);
  gatherConstraints(start, start);
  checkSharedPlaces(start);
  gatherGroups();
  setTime(start);
  applyMappings();
  computeGravity();
  findLinearSolver();
  preparePositionConstraints();
}

// ---- collection ----

void System::collect() {
  node_.collect(states_);
  node_.collect(force_fields_);
  node_.collect(masses_);
  node_.collect(constraints_);
  node_.collect(position_constraints_);
  node_.collect(mappings_);
  if (states_.empty())
    throw ComponentError(
        fmt::format("there is no mechanical state in {} or below, so there is nothing to move", node_.path()),
        "a MechanicalObject in the integrator's node or below");
}

namespace {

template <class Actor>
std::vector<State*> statesOf(const Actor& actor) {
  return {&actor.state()};
}
std::vector<State*> statesOf(const ForceField& field) { return field.states(); }
std::vector<State*> statesOf(const ProjectiveConstraint& constraint) { return constraint.states(); }

template <class Actor>
void requireStateIn(const std::vector<State*>& states, const std::vector<Actor*>& actors) {
  for (const Actor* actor : actors)
    for (const State* state : statesOf(*actor))
      if (std::find(states.begin(), states.end(), state) == states.end())
        throw ComponentError(fmt::format("the {} {} acts on {}, which this integrator does not move", actor->roleText(),
                                         actor->path(), state->path()),
                             "components and their state below the same integrator");
}

}  // namespace

void System::checkActors() const {
  requireStateIn(states_, force_fields_);
  requireStateIn(states_, masses_);
  requireStateIn(states_, constraints_);
  requireStateIn(states_, position_constraints_);
  for (std::size_t i = 0; i < masses_.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (&masses_[i]->state() == &masses_[j]->state())
        throw ComponentError(fmt::format("{} has two masses: {} and {}", masses_[i]->state().path(), masses_[j]->path(),
                                         masses_[i]->path()),
                             "one mass a state", "remove one of them");
  for (std::size_t i = 0; i < mappings_.size(); ++i) {
    for (const State* state : {&mappings_[i]->input(), &mappings_[i]->output()})
      if (std::find(states_.begin(), states_.end(), state) == states_.end())
        throw ComponentError(fmt::format("the mapping {} joins {}, which this integrator does not move",
                                         mappings_[i]->path(), state->path()),
                             "both states of a mapping below the same integrator");
    for (std::size_t j = 0; j < i; ++j)
      if (&mappings_[i]->output() == &mappings_[j]->output())
        throw ComponentError(fmt::format("two mappings place {}: {} and {}", mappings_[i]->output().path(),
                                         mappings_[j]->path(), mappings_[i]->path()),
                             "one mapping a state");
    for (const ProjectiveConstraint* constraint : constraints_)
      for (const State* state : constraint->states())
        if (state == &mappings_[i]->output())
          throw ComponentError(
              fmt::format("{} holds nodes of {}, whose positions follow from {} by {}", constraint->path(),
                          state->path(), mappings_[i]->input().path(), mappings_[i]->path()),
              "constraints on the state that is mapped from");
  }
}

// A mapping comes after the one that places its input.
void System::orderMappings() {
  std::vector<Mapping*> waiting = std::move(mappings_);
  mappings_.clear();
  while (!waiting.empty()) {
    const auto ready = std::find_if(waiting.begin(), waiting.end(), [&waiting](const Mapping* mapping) {
      return std::none_of(waiting.begin(), waiting.end(),
                          [mapping](const Mapping* other) { return &other->output() == &mapping->input(); });
    });
    if (ready == waiting.end())
      throw ComponentError(
          fmt::format("the mappings go in a circle: {} needs the output of another one that waits for it",
                      waiting.front()->path()),
          "mappings from parents to children");
    mappings_.push_back(*ready);
    waiting.erase(ready);
  }
  // from the last to the first: a child that only places passive children is passive
  const auto acts = [this](const State* state) {
    const auto is_state = [state](const auto* actor) { return &actor->state() == state; };
    const auto has_state = [state](const auto* actor) {
      const auto states = actor->states();
      return std::find(states.begin(), states.end(), state) != states.end();
    };
    return std::any_of(force_fields_.begin(), force_fields_.end(), has_state) ||
           std::any_of(masses_.begin(), masses_.end(), is_state) ||
           std::any_of(position_constraints_.begin(), position_constraints_.end(), is_state);
  };
  std::vector<Mapping*> acting;
  for (auto mapping = mappings_.rbegin(); mapping != mappings_.rend(); ++mapping) {
    const State* child = &(*mapping)->output();
    const bool feeds =
        std::any_of(acting.begin(), acting.end(), [&](const Mapping* m) { return &m->input() == child; });
    (feeds || acts(child) ? acting : passive_mappings_).push_back(*mapping);
  }
  std::reverse(acting.begin(), acting.end());
  std::reverse(passive_mappings_.begin(), passive_mappings_.end());
  mappings_ = std::move(acting);
}

void System::layOut() {
  std::vector<State*> mapped;
  for (const auto* mappings : {&mappings_, &passive_mappings_})
    for (const Mapping* mapping : *mappings) mapped.push_back(&mapping->output());
  std::erase_if(states_,
                [&mapped](State* state) { return std::find(mapped.begin(), mapped.end(), state) != mapped.end(); });
  const std::size_t independent = states_.size();
  states_.insert(states_.end(), mapped.begin(), mapped.end());

  std::int64_t rows = 0;
  for (std::size_t i = 0; i < states_.size(); ++i) {
    rows += states_[i]->size();
    if (i < independent) independent_rows_ = Index(rows);
    if (rows > std::numeric_limits<Index>::max() / 9)
      throw ComponentError(fmt::format("{} nodes below one integrator are more than a 32-bit index can count", rows));
  }
  all_rows_ = Index(rows);
  for (Vector* vector : {&x, &v, &f}) vector->resize(all_rows_);
  if (!mappings_.empty())
    for (Vector* vector : {&mapped_x_, &mapped_v_, &mapped_p_, &mapped_f_}) vector->resize(all_rows_);
  projector_of_row_.assign(independent_rows_, -1);

  Index first = 0;
  for (State* state : states_) {
    const std::size_t size = std::size_t(state->size());
    if (state->position.size() != size || state->velocity.size() != size)
      throw ComponentError(fmt::format("{} has {} positions and {} velocities for {} rest positions", state->path(),
                                       state->position.size(), state->velocity.size(), size),
                           "as many of each");
    state->bind(first, x, v, f.rows());
    for (std::size_t i = 0; i < size; ++i) {
      x[first + Index(i)] = state->position[i];
      v[first + Index(i)] = state->velocity[i];
    }
    first += state->size();
  }
}

void System::findLinearSolver() {
  linear_solver_ = integrator_.linearSolver();
  if (linear_solver_ && linear_solver_->needsSymmetric() && !symmetric())
    for (const ForceField* field : force_fields_)
      if (const ForceTraits traits = field->traits();
          !traits.symmetric && (traits.has_stiffness || traits.velocity_dependent))
        throw ComponentError(fmt::format("{} solves symmetric systems only, and the derivative of {} is not symmetric",
                                         linear_solver_->path(), field->path()),
                             "a solver for unsymmetric matrices");
}

// ---- forces ----

void System::setTime(double t) {
  for (ForceField* field : timed_fields_) field->setTime(t);
}

void System::computeGravity() {
  gravity_force_.resize(all_rows_);
  for (const Mass* mass : masses_) {
    if (mass->node().gravity().isZero()) continue;
    mass->addGravity(gravity_force_);
    has_gravity_ = true;
  }
  if (has_gravity_) ++counts.gravity;
}

// Vectors of a caller end with the independent rows or have rows for mapped states that only mappings can fill.
ConstRows System::onAllRows(ConstRows p, Vector& work, bool is_position) const {
  if (mappings_.empty()) return p;
  std::memcpy(work.rows().data, p.data, std::size_t(independent_rows_) * row_doubles * sizeof(double));
  for (const Mapping* mapping : mappings_) is_position ? mapping->apply(work) : mapping->applyJ(work);
  return std::as_const(work).rows();
}

void System::pullBack(Rows all) const {
  for (auto mapping = mappings_.rbegin(); mapping != mappings_.rend(); ++mapping) (*mapping)->applyJT(all);
}

// (J^T f)' = J^T K J + dJ^T/dx f: the second term of each mapping with the whole force on its child.
void System::pullBackProduct(ConstRows p, double k, Rows all) const {
  for (auto mapping = mappings_.rbegin(); mapping != mappings_.rend(); ++mapping) {
    if (!(*mapping)->isLinear()) (*mapping)->addGeometricProduct(last_force_, p, k, all);
    (*mapping)->applyJT(all);
  }
}

void System::noteForceEvaluation(ConstRows f_now) {
  ++counts.forces;
  if (!mappings_linear_) copy(f_now, last_force_);
  if (stiffness_varies_) ++revision_;
}

void System::startForce(Rows out) const {
  if (has_gravity_)
    copy(gravity_force_, out);
  else
    clear(out);
}

void System::computeForce(ConstRows x_now, ConstRows v_now, Rows f_now) {
  const PhaseTimer timer(times.force);
  assert(f_now.count == all_rows_);
  const ConstRows x_all = onAllRows(x_now, mapped_x_, true), v_all = onAllRows(v_now, mapped_v_, false);
  startForce(f_now);
  for (ForceField* field : force_fields_) field->addForce(x_all, v_all, f_now);
  pullBack(f_now);
  noteForceEvaluation(f_now);
}

void System::computeForceAndProduct(ConstRows x_now, ConstRows v_now, ConstRows p, double k, double k_rayleigh,
                                    Rows out) {
  const bool asked = std::any_of(states_.begin(), states_.end(), [](const State* s) { return s->forceRequested(); });
  if (asked || !mappings_linear_) {  // the geometric stiffness of mappings needs the force alone too
    computeForce(x_now, v_now, f);
    copy(f, out);
    addStiffnessProduct(p, k, k_rayleigh, {out.data, independent_rows_});
    return;
  }
  const PhaseTimer timer(times.force);
  assert(out.count == all_rows_);
  const ConstRows x_all = onAllRows(x_now, mapped_x_, true), v_all = onAllRows(v_now, mapped_v_, false);
  const ConstRows p_all = onAllRows(p, mapped_p_, false);
  startForce(out);
  for (ForceField* field : force_fields_) {
    const double factor = k + k_rayleigh * field->rayleigh_stiffness;
    if (factor == 0 || !field->traits().has_stiffness) {
      field->addForce(x_all, v_all, out);
    } else {
      field->addForceAndProduct(x_all, v_all, p_all, factor, out);
    }
  }
  pullBack(out);
  noteForceEvaluation(out);
}

void System::applyActingMappings() {
  for (const Mapping* mapping : mappings_) mapping->apply(x);
  for (const Mapping* mapping : mappings_) mapping->applyJ(v);
}

void System::applyMappings() {
  applyActingMappings();
  for (const Mapping* mapping : passive_mappings_) mapping->apply(x);
  for (const Mapping* mapping : passive_mappings_) mapping->applyJ(v);
}

}  // namespace stroma
