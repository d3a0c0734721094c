// SPDX-License-Identifier: LGPL-2.1-or-later
// StaticSolver: the equilibrium f(x) = 0 under the loads of each step, by Newton's method.
//
//   -K(x) dx = f(x),   x += s dx,   K = df/dx
//
// with the free directions of the constraints only. s comes from a line search: Armijo backtracking on the potential energy when
// every force has one, else the norm of the residual must fall. Masses matter through gravity alone; after a step velocities are
// zero but for moved nodes. A tangent that is not positive definite gets a multiple of its own diagonal; the report says so.
//
// With forcing_term above 0 a solver by products solves early iterations loosely, and as well as Newton converges later
// (Eisenstat and Walker 1996). With PCGLinearSolver preconditioner="warped" one factorisation then serves many iterations, with
// preconditioner="multigrid" no factors are needed. What ends a step does not change. A scene that names no linear solver has
// AutomaticLinearSolver, and with it a forcing term of 0.1 unless all its forces are linear.
//
// How a step is found that is too much for one go, or for the approximate tangent of a force field, and how with Lagrangian constraints,
// stands in static_step.h. The run tells how many steps were divided. A step that has no result says under how much of its loads the last
// equilibrium is, and leaves that, or with moved nodes is taken back.
//
// A step ends when |f| <= relative_residual_tolerance_threshold * the |f| where the step starts (reactions of held nodes included), when
// these forces are round-off of those within a body on which nothing acts, when another threshold (off by default) is met, or when dx no
// longer changes x. After newton_iterations without that it has not converged, and leaves the best iterate (with Lagrangian constraints the
// last one); a run that ends so has no result (exit code 3). SOFA: 1 iteration, four times 1e-5. A NewtonRaphsonSolver has the settings.
//
// A body that is free to move or turn as a whole and whose loads push it that way has no equilibrium: the step ends with a sentence naming
// the body and the direction or axis. So does one that Lagrangian constraints alone hold: these have forces only where the matrix of the
// others has an inverse. A body is what forces tie together: a state can hold several. With sleepDistance one that keeps its place is not
// computed until something changes (sleep.h).
//
// Example:
// <Node name="root" dt="1" gravity="0 -9.81 0">
//   <StaticSolver newton_iterations="20"/>
//   <SparseLDLSolver/>
//   <MechanicalObject position="0 0 0  1 0 0  0 1 0  0 0 1"/>
//   <MeshTopology position="0 0 0  1 0 0  0 1 0  0 0 1" tetrahedra="0 1 2 3"/>
//   <UniformMass totalMass="1"/>
//   <TetrahedronFEMForceField youngModulus="5000" poissonRatio="0.3" method="small"/>
//   <FixedProjectiveConstraint indices="0 1 2"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "components/integrators/free_body.h"
#include "components/integrators/solve_potential.h"
#include "components/integrators/newton_solver.h"
#include "components/integrators/sleep.h"
#include "components/integrators/soft_directions.h"
#include "components/integrators/static_step.h"
#include "components/integrators/uncoupled_constraint_correction.h"
#include "components/integrators/usual_forcing.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"
#include "framework/simulation/integrator.h"
#include "framework/simulation/system_report.h"

namespace stroma {
namespace {

class StaticSolver final : public Integrator, public RespectsStepLimits, public FindsMultipliers {
 public:
  bool respectsStepLimits() const override { return true; }
  void declare(DataTable& table) override;
  void compile(System& system) override;
  StepReport step(System& system, const StepContext& context) override;
  std::string describe() const override;
  bool movesInTime() const override { return false; }
  std::string doubt() const override { return doubts_.doubt(path()); }
  void sceneChanged() override { is_checked_ = false, sleep_.wake(); }
  void stepTaken(const StepContext& context) override {
    if (!sleep_.stepTaken(context.dt)) step_.exact.stepTaken();
    step_.conditioned.stepTaken();
  }
  void reset() override {
    step_.exact.reset(), sleep_.reset(), step_.conditioned.reset(), doubts_ = {}, is_checked_ = false, exact_tangent_steps_ = 0;
  }
  void serialize(Archive& archive) override {
    step_.exact.serialize(archive), doubts_.serialize(archive), sleep_.serialize(archive), step_.conditioned.serialize(archive);
    step_.problem.serialize(archive), archive.value("is_checked", is_checked_);
    archive.value("held", held_);
  }

 private:
  bool checkFreeBodies(System& system, StopToken stop, StepReport& report);
  bool endsUnstable(System& system, StopToken stop, StepReport& report);

  NewtonSettings settings_;
  std::vector<double> graph_;
  Link<NewtonSolver> newton_link_{"Newton solver"};
  NewtonSolver* settings_component_ = nullptr;
  double smallest_part_ = 1.0 / 1024;
  StaticStep step_{settings_, smallest_part_};
  int exact_tangent_steps_ = 0;
  Vector force_, good_;                    ///< work space
  bool is_checked_ = false;                ///< no body was free when something last changed
  long checked_revision_ = -1;             ///< of what held bodies then
  long held_ = 0;                          ///< directions of nodes, in the last step
  StaticDoubts doubts_;
  Sleep sleep_;
};

void StaticSolver::declare(DataTable& table) {
  settings_.iterations = 200;
  declareNewton(table, settings_,
                {.iterations = "newton_iterations",
                 .relative_residual = "relative_residual_tolerance_threshold",
                 .absolute_residual = "absolute_residual_tolerance_threshold",
                 .relative_correction = "relative_correction_tolerance_threshold",
                 .absolute_correction = "absolute_correction_tolerance_threshold",
                 .residual = "|f|",
                 .unit = "N"});
  declareForcing(table, "forcing_term", settings_, "|K dx + f| / |f|", "where AutomaticLinearSolver solves");
  table.add("smallest_part", smallest_part_)
      .help("the smallest share of a step's loads and motion that a step which fails is divided into; 1: steps are not "
            "divided. Neither are they with fewer than five Newton iterations or should_diverge_when_residual_is_growing")
      .unit("-")
      .min(1e-6)
      .max(1);
  table.add("should_diverge_when_residual_is_growing", settings_.stop_when_residual_grows)
      .help("end the run when an iteration makes the residual larger");
  table.add("residualGraph", graph_).help("|f| of the last step's Newton iterations").unit("N").output();
  declareExactTangentSteps(table, exact_tangent_steps_), declareLinearSolver(table);
  table.addLink("newtonSolver", newton_link_)
      .help("a NewtonRaphsonSolver, whose settings stand for this component's; without it, the one of the same node");
  sleep_.declare(table), step_.conditioned.declare(table);
}

void StaticSolver::compile(System& system) {
  refuseRayleighFactors(system, "statics");
  assert(system.linearSolver() && "Integrator::missingPartner() sees to it");
  settings_component_ = findNewtonSolver(*this, newton_link_);
  if (settings_component_) {
    refuseSettingsBeside(*this, *settings_component_);
    const NewtonSettings own = settings_;
    settings_ = settings_component_->settings();
    settings_.stop_when_residual_grows = own.stop_when_residual_grows;
    settings_.forcing = own.forcing;
  }
  if (!data().find("forcing_term")->isSet()) takeUsualForcing(system, settings_);
  settings_.use_energy = settings_.restores_soft_directions = havePotentialInSolves(system);
  settings_.looks_for_unstable_modes = hasExactTangents(system), settings_.slow_factors = 1;
  // a limit that the scene writes is the only one
  settings_.patience = settings_component_ || data().find("newton_iterations")->isSet() ? 0 : 10;
  step_.compile(system, *system.linearSolver()), sleep_.compile(system);
  if (!step_.conditioned.empty()) UncoupledConstraintCorrection::tellIdle(*this, "finds equilibria");
  force_.resize(system.independentRows()), good_.resize(system.independentRows());
  graph_.reserve(std::size_t(settings_.iterations) + 2);
  if (settings_component_) settings_component_->prepare(graph_.capacity());
}

/// False, with the sentence, when a body has no equilibrium where the step starts; or when it is asked to stop.
bool StaticSolver::checkFreeBodies(System& system, StopToken stop, StepReport& report) {
  step_.problem.giveUp(), step_.problem.setShare(1);
  step_.problem.residual(force_);
  report.stopped = stop.isStopAsked();
  if (report.stopped) return false;
  const std::string sentence = freeBody(system, force_);
  checked_revision_ = revisionOfHolds(system);
  is_checked_ = sentence.empty(), report.stopped = stop.isStopAsked();
  if (is_checked_ || report.stopped) return !report.stopped;
  report.reason = sentence, report.diverged = true;
  if (!step_.conditioned.empty())
    report.reason += fmt::format(
        ". What forces of constraint alone hold, as those of {}, is free here: AttachProjectiveConstraint ties it, or "
        "EulerImplicitSolver with rayleighMass brings it to rest",
        dynamic_cast<const Component&>(*system.actors().lagrangian_constraints.front()).path());
  return false;
}

/// Where no iteration came close, as of a straight column that is pressed and only becomes shorter: by the tangent of the end. Only with
/// solvers that make factors: the others would need more than all of the step.
bool StaticSolver::endsUnstable(System& system, StopToken stop, StepReport& report) {
  const auto& fields = system.forceFields();
  const bool is_linear = std::all_of(fields.begin(), fields.end(), [](const ForceField* field) { return field->traits().linear; });
  if (is_linear || !settings_.looks_for_unstable_modes || !step_.conditioned.empty() || !step_.newton.shouldLookForUnstableMode())
    return false;
  if (!report.newton_converged || report.failed() || report.factorisations == 0) return false;
  return hasUnstableMode(*system.linearSolver(), step_.problem.tangent(), {.stop = stop}, report);
}

StepReport StaticSolver::step(System& system, const StepContext& context) {
  if (sleep_.passesOver(context)) return {};
  clear(system.v);
  step_.problem.begin();
  StepReport report;
  const long held_before = std::exchange(held_, heldDirections(system.constraints()));
  if (!is_checked_ || held_ != held_before) {
    step_.exact.end();  // rigid motions are seen in the scene's tangent
    if (!checkFreeBodies(system, context.stop, report)) return report;
  }
  step_.exact.choose(system);
  const bool began_exact = step_.exact.isOn();
  report = step_.solve(context);
  if (began_exact && !report.stopped && (!report.newton_converged || report.diverged)) {
    // it helped before, and does not here
    step_.exact.end();
    step_.problem.giveUp();
    const StepReport before = std::exchange(report, step_.solve(context));
    addCounts(before, report);
  }
  if (report.stopped) return report;
  const bool tried_exact = step_.exact.isOn();
  if (step_.exact.endStep(report.newton_converged && !report.diverged)) step_.problem.residual(force_);
  exact_tangent_steps_ += step_.exact.isOn() && !began_exact;
  // what turns or comes and goes from step to step is looked at only where a solve has failed: it takes memory and time
  if (!report.newton_converged && settings_.iterations > 1 && revisionOfHolds(system) != checked_revision_) {
    const Rows x = system.independent(system.x);
    copy(x, good_);
    if (!checkFreeBodies(system, context.stop, report)) return report;
    copy(good_, x);
    step_.problem.residual(force_);
  }
  report.unsolved = !report.newton_converged;
  const bool is_unstable = step_.newton.isUnstable() || endsUnstable(system, context.stop, report);
  if (report.stopped) return report;
  doubts_.noteStability(report, hasExactTangents(system), is_unstable, step_.newton.history(), context.t + context.dt);
  doubts_.noteUnmoved(report, settings_, [&] { return norm(system.independent(system.f)) > 3 * step_.problem.roundOff().residual; });
  if (report.unsolved && !report.diverged)
    report.reason += tried_exact ? "; with the exact tangent too" : exactTangentHint(system, report);
  graph_.assign(step_.newton.history().begin(), step_.newton.history().end());
  if (settings_component_) settings_component_->noteResult(report, step_.newton);
  if (report.unsolved && !settings_.keep_unconverged) step_.problem.giveUp(), report.reason += "; the state before the step was kept";
  return sleep_.judged(report);
}

std::string StaticSolver::describe() const {
  return fmt::format("static equilibrium: up to {} Newton iterations to a relative residual of {:g}, line search on {}{}",
      settings_.iterations, settings_.relative_residual,
      settings_.use_energy ? "the potential energy" : "the work of the residual",
      step_.mayDivide() ? fmt::format("; a step that fails is divided into parts of {:.2g} or more", smallest_part_) : "") +
      sleep_.describe();
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(static_solver) {
  factory.add<stroma::StaticSolver>("StaticSolver", "static equilibrium by Newton's method with line search");
}
