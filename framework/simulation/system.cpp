// SPDX-License-Identifier: LGPL-2.1-or-later
// A system: how it is put together, and what a step does besides forces.
#include "framework/simulation/system.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "framework/mechanics/frames.h"
#include "framework/scene/node.h"
#include "framework/scene/spans.h"
#include "framework/simulation/integrator.h"
#include "framework/simulation/step_limits.h"

namespace stroma {

namespace {

std::vector<Component*> componentsOf(const SystemMembers& members) {
  std::vector<Component*> found;
  members.integrator->node().collect(found);
  for (const MergedIntegrator& merged : members.merged) merged.integrator->node().collect(found);
  for (Component* acting : members.acting)
    if (std::find(found.begin(), found.end(), acting) == found.end()) found.push_back(acting);
  return found;
}

}  // namespace

System::System(const SystemMembers& members)
    : integrator_(*members.integrator),
      merged_(members.merged),
      components_(componentsOf(members)),
      actors_(collectActors(members)),
      constraints_(actors_),
      matrix_(*this) {
  for (Vector* vector : {&x, &v, &f}) vector->resize(allRows());
  bindStates();
  compileActors(actors_);
  mappings_.compile(actors_);
  const double start = node().root().root_time;
  constraints_.compile(start, x, v);
  setTime(start);
  applyMappings();
  computeGravity();
  checkLinearSolver();
  corrections_.compile(actors_, integrator_, constraints_);
  std::vector<Index> unanswered;
  for (const ProjectiveConstraint* constraint : constraints_.all()) constraint->addUnansweredRows(unanswered);
  if (!unanswered.empty()) states().front()->requestForce();  // a run says what they take
}

void System::bindStates() {
  Index first = 0;
  for (State* state : states()) {
    const std::size_t size = std::size_t(state->size());
    if (state->position.size() != size || state->velocity.size() != size)
      throw ComponentError(fmt::format("{} has {} positions and {} velocities for {} rest positions", state->path(),
                                       state->position.size(), state->velocity.size(), size),
                           "as many of each");
    state->bind(first, x, v, f.rows());
    for (std::size_t i = 0; i < size; ++i) {
      placeRow(state->kindOf(Index(i)), state->position[i], x, first + Index(i));
      v[first + Index(i)] = state->velocity[i];
    }
    first += state->size();
  }
}

LinearSolver* System::linearSolver() const {
  if (!solver_) solver_ = integrator_.linearSolver();  // a search of the node, and steps ask
  return *solver_;
}
Node& System::node() const { return integrator_.node(); }

void System::beginStep(const StepContext& context) {
  const Span span("begin step", &integrator_);
  setTime(context.t_end);
  tellStepBegins(*this, x, context.t, context.t_end);
  constraints_.begin(context, x, v);
  mappings_.place(x, v);
}

void System::endStep(const StepContext& context, ConstRows x_start, StepReport& report) {
  const Span span("end step", &integrator_);
  const bool moved = constraints_.end(context, x, v);
  // where rows are left behind, mapped states follow when they are complete; those on which nothing acts always do
  if (moved || !integrator_.stateOwner()) mappings_.place(x, v);
  if (corrections_.empty()) return;
  corrections_.enforce(context, x_start, x, v, report);
  mappings_.place(x, v);
}

void System::keepSolver() { if (LinearSolver* solver = linearSolver()) solver->keepFor(matrix_); }
void System::takeSolverBack() { if (LinearSolver* solver = linearSolver()) solver->takeBackFor(matrix_); }

void System::applyMappings() {
  mappings_.place(x, v);
  mappings_.placePassive(x, v);
}

}  // namespace stroma
