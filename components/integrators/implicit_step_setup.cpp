// SPDX-License-Identifier: LGPL-2.1-or-later
// Attributes of an implicit step, and what it needs before the first.
#include <algorithm>
#include <cassert>

#include "components/integrators/implicit_step.h"
#include "components/integrators/usual_forcing.h"

namespace stroma {

void ImplicitStep::declareDamping(DataTable& table) {
  table.add("rayleighStiffness", rayleigh_stiffness)
      .recompiled()
      .help("damping proportional to the stiffness, that of BarrierContact left out")
      .unit("s")
      .min(0);
  table.add("rayleighMass", rayleigh_mass).recompiled().help("damping proportional to the mass").unit("1/s").min(0);
}

void ImplicitStep::declareNewton(DataTable& table) {
  table.add("newtonIterations", newton_settings.iterations)
      .recompiled()
      .help("1: one linear solve per step, as SOFA; more: the step's equations are solved by Newton's method")
      .unit("-")
      .min(1);
  table.add("newtonTolerance", newton_settings.relative_residual)
      .recompiled()
      .help("residual at which Newton's method ends, relative to the forces where the step starts")
      .unit("-")
      .min(0, false)
      .max(1, false);
  declareForcing(table, "newtonForcing", newton_settings, "relative residual", "where the scene names no linear solver");
}

void ImplicitStep::declareNewtonSolver(DataTable& table) {
  declareExactTangentSteps(table, exact_tangent_steps_);
  table.add("residualGraph", graph_).help("residuals of the last step's Newton iterations").unit("N s").output();
  table.addLink("newtonSolver", newton_link_)
      .help("a NewtonRaphsonSolver, whose settings stand for this component's; without it, the one of the same node");
}

void ImplicitStep::compile(Integrator& integrator, System& system) {
  system_ = &system;
  solver_ = system.linearSolver();
  assert(solver_ && "Integrator::missingPartner() sees to it");
  system.constraints().requireMass();
  has_rayleigh_mass_ = rayleigh_mass != 0;
  for (const Mass* mass : system.masses()) has_rayleigh_mass_ = has_rayleigh_mass_ || mass->rayleigh_mass != 0;
  has_own_stiffness_damping_ = depends_on_time_ = false;
  bool from_energy = system.isConservative();
  for (const ForceField* field : system.forceFields()) {
    const ForceTraits traits = field->traits();
    has_own_stiffness_damping_ =
        has_own_stiffness_damping_ || field->rayleigh_stiffness != 0 || (rayleigh_stiffness != 0 && traits.undamped);
    depends_on_time_ = depends_on_time_ || traits.time_dependent;
    from_energy = from_energy && !traits.velocity_dependent;
  }
  has_rayleigh_stiffness_ = rayleigh_stiffness != 0 || has_own_stiffness_damping_;

  settings_component_ = findNewtonSolver(integrator, newton_link_);
  newton_.settings = settings_component_ ? settings_component_->settings() : newton_settings;
  const Data* const forcing = integrator.data().find("newtonForcing");
  newton_.settings.forcing = forcing && forcing->isSet() ? newton_settings.forcing : usualForcingOfSteps(system);
  // an iteration costs as much as a digit of a solve; errors of steps add up
  newton_.settings.forcing_reach = 10, newton_.settings.forcing_margin = 0.05;
  // the turn that a velocity makes in a step is no gradient of it
  newton_.settings.use_energy = from_energy && !system.motion().turns() && !system.hasCurvedInertia();
  bodies_.compile(system);
  for (std::vector<Vec3>* list : {&start_momenta_, &end_momenta_, &momentum_predictor})
    list->assign(bodies_.count(), Vec3::Zero());
  right_side_.resize(system.allRows());
  for (Vector* vector : {&change_, &constant_, &work_, &position_predictor, &velocity_predictor})
    vector->resize(system.independentRows());
  multipliers_.compile(system);
  if (!iterates()) return;
  newton_.compile(system.independentRows());
  limits_.compile(system);
  for (Vector* vector : {&x0_, &v0_}) vector->resize(system.independentRows());
  if (!limits_.empty()) carried_.resize(system.independentRows());
  if (!multipliers_.empty())
    for (Vector* vector : {&direction_, &last_v_}) vector->resize(system.independentRows());
  graph_.reserve(std::size_t(newton_.settings.iterations) + 2);
  if (settings_component_) settings_component_->prepare(graph_.capacity());
}

}  // namespace stroma
