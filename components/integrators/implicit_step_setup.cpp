// SPDX-License-Identifier: LGPL-2.1-or-later
// Attributes of an implicit step, and what it needs before the first.
#include <fmt/format.h>

#include <algorithm>
#include <cassert>

#include "components/integrators/constraint_sweeps.h"
#include "components/integrators/exact_tangent.h"
#include "components/integrators/implicit_step.h"
#include "components/integrators/solve_potential.h"
#include "components/integrators/uncoupled_constraint_correction.h"
#include "components/integrators/usual_forcing.h"

namespace stroma {

/// Nodes are moved beside a mass that ties them to others: System::constraints() then refuses them, with or without mass.
static bool movesTiedNodes(System& system) {
  const auto& constraints = system.constraints().all();
  const auto moves = [](const ProjectiveConstraint* constraint) { return constraint->prescribesMotion(); };
  const auto ties = [&system](const Mass* mass) {
    return !mass->leavesMovedAlone() && !(mass->isDiagonal() && mass->state().firstRow() < system.independentRows());
  };
  return std::any_of(constraints.begin(), constraints.end(), moves) &&
         std::any_of(system.masses().begin(), system.masses().end(), ties);
}

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
      .help(
          "1: one linear solve per step, as SOFA; more: the step's equations are solved by Newton's method; 0: up to 30 iterations of "
          "Newton's method with BarrierContact; without it one linear solve, and two for a rule of second order where a force "
          "field's stiffness is an approximation (the rotated methods with tangent=\"warped\"), is damped or, where the rule damps "
          "nothing, changes in the step; three where forces turn rigid bodies: with one the rule may gain energy until it explodes, "
          "and is of first order unless K only changes")
      .unit("-")
      .min(0);
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
      .help("a NewtonRaphsonSolver, whose settings replace this component's; by default the one in the same node");
}

/// What makes one linear solve less than a rule of second order needs, or empty.
static std::string approximationIn(const System& system, double rayleigh_stiffness, bool turns) {
  const bool is_loaded = !system.forceFields().empty() || system.hasCurvedInertia() || !system.actors().lagrangian_constraints.empty();
  if (turns && is_loaded) return "rigid bodies and nodes mapped to them rotate within a step";
  for (const ForceField* field : system.forceFields()) {
    const ForceTraits traits = field->traits();
    if (traits.linear) continue;
    if (!traits.exact_tangent) return "the stiffness of " + field->path() + " is not the exact derivative of its force";
    const bool is_damped = field->rayleigh_stiffness != 0 || (rayleigh_stiffness != 0 && !traits.undamped);
    if (is_damped && !traits.constant_stiffness) return "rayleighStiffness damps " + field->path() + ", whose stiffness changes";
  }
  return {};
}

/// What changes the stiffness within a step where it is exact, or empty. One solve keeps the order, but what is fast against the
/// step feels the stiffness of its start alone: a rule that damps nothing keeps the energy that this makes.
static std::string changesIn(const System& system) {
  for (const ForceField* field : system.forceFields()) {
    const ForceTraits traits = field->traits();
    if (traits.has_stiffness && !traits.linear && !traits.constant_stiffness && !traits.lagged && !traits.time_dependent)
      return "the stiffness of " + field->path() + " changes within a step";
  }
  return {};
}

void ImplicitStep::chooseSolves(bool keeps_energy) {
  NewtonSettings& settings = newton_.settings;
  limiter_.clear();
  if (settings.iterations == needed_solves && !only_linear)
    for (const ForceField* field : system_->forceFields())  // one linear solve does not ask them
      if (dynamic_cast<const StepLimiter*>(field)) settings.iterations = enough_with_limits, limiter_ = field->path();
  const bool turns = bodies_.count() > 0 || !system_->mappingChain().isLinear();
  approximation_ = second_order ? approximationIn(*system_, rayleigh_stiffness, turns) : std::string();
  keeps_order_ = approximation_.empty();
  if (second_order && keeps_energy && keeps_order_) approximation_ = changesIn(*system_);
  enough_solves_ = turns ? 3 : 2;  // the first solve of several leaves an error of h^2 in turns, and the second still one of h^3
  energy_.compile(*system_, settings.iterations == 1 && !approximation_.empty());
  if (settings.iterations != needed_solves) return;
  settings.fixed_count = !approximation_.empty();
  settings.iterations = settings.fixed_count ? enough_solves_ : 1;
  // moments of light bodies are little beside the weight of others
  if (turns) settings.relative_residual = std::min(settings.relative_residual, 1e-13);
  settings.line_search_iterations = 0;
}

void ImplicitStep::compile(Integrator& integrator, System& system) {
  system_ = &system;
  solver_ = system.linearSolver();
  assert(solver_ && "Integrator::missingPartner() sees to it");
  if (!allows_massless || movesTiedNodes(system)) system.constraints().requireMass();
  has_rayleigh_mass_ = rayleigh_mass != 0;
  for (const Mass* mass : system.masses()) has_rayleigh_mass_ = has_rayleigh_mass_ || mass->rayleigh_mass != 0;
  has_own_stiffness_damping_ = depends_on_time_ = false;
  bool from_energy = havePotentialInSolves(system);
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
  bodies_.compile(system);
  chooseSolves(integrator.keepsEnergy());
  if (!(forcing && forcing->isSet())) newton_.settings.forcing = iterates() ? usualForcingOfSteps(system) : 0;
  // an iteration costs as much as a digit of a solve; errors of steps add up
  newton_.settings.forcing_reach = 10, newton_.settings.forcing_margin = 0.05;
  lends_energy_ = !system.isConservative();
  meets_walls_ = std::ranges::any_of(system.forceFields(), [](const ForceField* field) { return field->traits().lagged; });
  // the turn that a velocity makes in a step is no gradient of it
  newton_.settings.use_energy = from_energy && !system.motion().turns() && !system.hasCurvedInertia();
  for (std::vector<Vec3>* list : {&start_momenta_, &end_momenta_, &momentum_predictor})
    list->assign(bodies_.count(), Vec3::Zero());
  right_side_.resize(system.allRows());
  for (Vector* vector : {&change_, &constant_, &work_, &position_predictor, &velocity_predictor})
    vector->resize(system.independentRows());
  multipliers_.compile(system), whole_.compile(system), measure_.compile(system.motion()), light_.compile(system);
  right_sides_.clear();
  for (const ProjectiveConstraint* constraint : system.constraints().all())
    if (const auto* side = dynamic_cast<const ProjectsRightSide*>(constraint); side && side->leavesMatrix()) {
      if (!solvesOnce() || !multipliers_.empty())
        throw ComponentError(constraint->path() + " has inMatrix=\"false\", which is for one linear solve per step without Lagrangian "
                             "constraints", "newtonIterations=\"1\", or no inMatrix");
      right_sides_.emplace_back(constraint, side);
    }
  if (!multipliers_.empty() && solvesOnce() && !one_round) ConstraintSweeps::tellIdle(integrator, integrator.path() + " has no oneRound");
  chooseTurning(), findDamped();
  if (solvesOnce()) return;
  if (!multipliers_.empty()) UncoupledConstraintCorrection::tellIdle(integrator, "makes several linear solves in a step");
  if (!multipliers_.empty()) ConstraintSweeps::tellIdle(integrator, integrator.path() + " makes several linear solves in a step");
  newton_.compile(system.independentRows());
  if (iterates()) limits_.compile(system), limits_.wantStartForces(false);
  for (Vector* vector : {&x0_, &v0_}) vector->resize(system.independentRows());
  if (!limits_.empty()) carried_.resize(system.independentRows());
  if (!multipliers_.empty()) conditions_.compile(system, *this, multipliers_, constant_);
  graph_.reserve(std::size_t(newton_.settings.iterations) + 2);
  if (settings_component_) settings_component_->prepare(graph_.capacity());
}

/// Steps of a law that resists changes of volume far more than of shape end with a volume that the linearised law does not
/// see. A NeoHookean block fixed at one end and released under its weight lacked 8 % of its displacement after ten steps of a
/// twentieth of its swing with a Poisson's ratio of 0.49, and 28 % with 0.499; with Newton's method it has the way of 0.45 at
/// both.
std::string ImplicitStep::doubtOfOneSolve(const std::string& path) const {
  if (iterates()) return {};
  for (const ForceField* field : system_->forceFields())
    if (const Data* why = field->data().find("stiffInVolume"); why && !why->print().empty())
      return fmt::format("{} solves each step {}, and {} is nearly incompressible ({}): its displacement lags by a few per cent up "
                         "to a half. newtonIterations=\"20\" solves its steps",
                         path, solvesOnce() ? "once" : "twice", field->path(), why->print());
  for (const ForceField* field : system_->forceFields())
    if (hasUndrainedTangent(*field))
      return fmt::format("{} solves each step {}, with a tangent of {} that keeps the fluid in each element: it settles too late, "
                         "the more so the stiffer the fluid is compared with the tissue. tangent=\"coupled\" lets it flow",
                         path, solvesOnce() ? "once" : "twice", field->path());
  return {};
}

std::string ImplicitStep::doubt(const std::string& path) const {
  const double gained = energy_.gained();
  if (gained == 0) return multipliers_.doubt().empty() ? doubtOfOneSolve(path) : multipliers_.doubt();
  return fmt::format("{} has gained {:.3g} J with no work done on it: newtonIterations=\"1\" makes its rule one {}, which "
                     "gains energy until the run explodes, because {}. newtonIterations=\"{}\", or 0, makes the solves that it needs",
                     path, gained, keeps_order_ ? "without bounds at large steps" : "of first order", approximation_, enough_solves_);
}

}  // namespace stroma
