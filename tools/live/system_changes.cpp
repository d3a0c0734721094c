// SPDX-License-Identifier: LGPL-2.1-or-later
// What a system recomputes when its scene is changed, or its state is set, between steps.
#include <algorithm>

#include "framework/scene/archive.h"
#include "framework/simulation/integrator.h"
#include "framework/simulation/system.h"

namespace stroma {

void System::componentsChanged(const std::vector<Component*>& changed, double t) {
  const auto compileChanged = [&changed](const auto& actors) {
    for (auto* actor : actors)
      if (std::find(changed.begin(), changed.end(), actor) != changed.end()) actor->compile();
  };
  compileChanged(actors_.masses);
  compileChanged(actors_.force_fields);
  compileChanged(actors_.mappings);
  compileChanged(actors_.passive_mappings);
  sortByTraits(actors_);
  setTime(t);
  gravityChanged();  // masses may be others
  checkLinearSolver();
  constraints_.componentsChanged(t, v);
  corrections_.compile(actors_, integrator_, constraints_);
  matrix_.termsChanged();
  integrator_.compile(*this);
}

void ConstraintSet::componentsChanged(double t, Rows v) {
  const std::vector<Index> held_before = projector_of_row_;
  const std::vector<NodeProjector> before = projectors_;
  change_ = std::any_of(all().begin(), all().end(), [](const ProjectiveConstraint* constraint) {
    return !constraint->isConstant() || constraint->endTime() >= 0;
  });
  refuseTurningRows();
  reserve(t);
  gather(t, t);
  // what is newly held stops; directions that were held before keep the velocity that they were given
  for (const NodeProjector& held : projectors_) {
    const Index old = held_before[held.row];
    const Mat3 free_before = old < 0 ? Mat3(Mat3::Identity()) : before[old].projector;
    v[held.row] -= ((Mat3::Identity() - held.projector) * (free_before * v[held.row])).eval();
  }
  updateInverseMass();
  if (!relations_.empty()) relations_.set(gathered_relations_, projectors_, groups_, relationWeights());
  ++revision_;
}

void System::gravityChanged() {
  has_gravity_ = false;
  computeGravity();
}

void System::setInput(long number, const Input& input, State& state) {
  if (!inputs_) inputs_ = std::make_unique<InputForces>(*states().front());
  const bool were_empty = inputs_->empty(), were_damped = inputs_->isDamped();
  if (inputs_->set(number, input, state)) inputsChanged(were_empty, were_damped);
}

void System::removeInput(long number) {
  if (!inputs_) return;
  const bool were_damped = inputs_->isDamped();
  if (inputs_->remove(number)) inputsChanged(false, were_damped);
}

void System::inputsChanged(bool were_empty, bool were_damped) {
  if (were_empty) actors_.force_fields.push_back(inputs_.get());
  if (inputs_->empty()) std::erase(actors_.force_fields, inputs_.get());
  sortByTraits(actors_);
  matrix_.valuesChanged();
  if (were_damped != inputs_->isDamped() && !integrator_.stateOwner()) {
    // how an integrator searches along a line depends on whether all forces have a potential
    Archive kept;
    integrator_.serialize(kept);
    integrator_.compile(*this);
    kept = kept.readable();
    integrator_.serialize(kept);
  }
  integrator_.sceneChanged();
}

void System::serialize(Archive& archive, const StepContext& last) {
  matrix_.serialize(archive);
  if (archive.isReading()) {
    // what the last step left: the next one then changes as much as it would have
    setTime(last.t_end);
    constraints_.resume(last);
    applyMappings();
    matrix_.termsChanged();
  }
  archive.enter(integrator_.path() + ":linear solver");
  if (LinearSolver* solver = linearSolver()) solver->serializeFor(matrix_, archive);
}

}  // namespace stroma
