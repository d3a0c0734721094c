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
// A step whose loads or whose prescribed motion are too much for one go is divided. With f0 = f(x0) the forces out of
// balance where the step starts and s the share of the step, a part solves
//
//   f(x) - (1 - s) f0 = 0,   prescribed nodes where they are at t + s dt
//
// and s grows to 1 by parts that become smaller by 4 where one fails and larger by 2 after each that does not: at s = 0 the
// start is in balance whatever acts on it. Parts end at a relative residual of 1e-4, the last one at the step's own. The run
// tells how many steps were divided. No part is smaller than `smallest_part`: then the step is tried once more in one go (patient_solve.h).
// Where that fails, too, it says under how much of its loads the last equilibrium is, and leaves that, or with moved nodes is taken back.
//
// Before that, a solve that fails or gets no further with the approximate tangent of a force field (tangent="warped") is tried
// with the exact one, from the best iterate and then from where it began. One that gets on by a factor above 0.1, with more than
// six such still to go, takes it too, where it is symmetric (method svd). Where that helped, later steps begin with it. The linear
// solver must take it: CGLinearSolver takes symmetric ones only. With fewer than five Newton iterations it is not tried.
//
// With Lagrangian constraints, contact by ConstraintContact among them, f(x) + J^T l = 0 and their conditions are solved together
// (conditions_newton.h), in one go: take smaller steps where that fails. What fails with the approximate tangent is tried once with
// the exact one, from where the step began. Slides and ways are those of the step.
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

#include "components/integrators/conditioned_statics.h"
#include "components/integrators/equilibrium.h"
#include "components/integrators/exact_tangent.h"
#include "components/integrators/free_body.h"
#include "components/integrators/lent_energy.h"
#include "components/integrators/newton_solver.h"
#include "components/integrators/patient_solve.h"
#include "components/integrators/sleep.h"
#include "components/integrators/uncoupled_constraint_correction.h"
#include "components/integrators/usual_forcing.h"
#include "components/integrators/while_on.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"
#include "framework/simulation/integrator.h"
#include "framework/simulation/system_report.h"

namespace stroma {
namespace {

class StaticSolver final : public Integrator, public HeedsStepLimits, public FindsMultipliers {
 public:
  bool heedsStepLimits() const override { return true; }
  void declare(DataTable& table) override;
  void compile(System& system) override;
  StepReport step(System& system, const StepContext& context) override;
  std::string describe() const override;
  bool movesInTime() const override { return false; }
  std::string doubt() const override { return doubts_.doubt(path()); }
  void sceneChanged() override { is_checked_ = false, sleep_.wake(); }
  void stepTaken(const StepContext& context) override {
    if (!sleep_.stepTaken(context.dt)) exact_.stepTaken();
    conditioned_.stepTaken();
  }
  void reset() override {
    exact_.reset(), sleep_.reset(), conditioned_.reset(), doubts_ = {}, is_checked_ = false, exact_tangent_steps_ = 0;
  }
  void serialize(Archive& archive) override {
    exact_.serialize(archive), doubts_.serialize(archive), sleep_.serialize(archive), conditioned_.serialize(archive);
    problem_.serialize(archive), archive.value("is_checked", is_checked_);
    archive.value("held", held_);
  }

 private:
  bool mayDivide() const { return smallest_part_ < 1 && triesMore(); }
  /// With less the scene does not ask for an equilibrium.
  bool triesMore() const { return settings_.iterations >= 5 && !settings_.stop_when_residual_grows; }
  bool checkFreeBodies(System& system, StopToken stop, StepReport& report);
  StepReport solvePart(System& system, const StepContext& context);
  StepReport solveWithFallback(System& system, const StepContext& context);
  StepReport solveInParts(System& system, const StepContext& context);
  StepReport solveConditions(System& system, const StepContext& context);
  bool advancePrescribed(System& system, const StepContext& context, StepReport& report);

  NewtonSettings settings_;
  std::vector<double> graph_;
  Link<NewtonSolver> newton_link_{"Newton solver"};
  LinearSolver* solver_ = nullptr;
  NewtonSolver* settings_component_ = nullptr;
  Equilibrium problem_;
  Newton newton_;
  ConditionedStatics conditioned_;
  ExactTangent exact_;
  int exact_tangent_steps_ = 0;
  double smallest_part_ = 1.0 / 1024;
  Vector force_, good_;
  Vector mode_, moved_, moved_v_, displacement_;  ///< work space of advancePrescribed(), shape (all rows)
  bool is_free_ = false;                   ///< the step is made as if there were no Lagrangian constraints
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
  sleep_.declare(table), conditioned_.declare(table);
}

void StaticSolver::compile(System& system) {
  refuseRayleighFactors(system, "statics");
  solver_ = system.linearSolver();
  assert(solver_ && "Integrator::missingPartner() sees to it");
  settings_component_ = findNewtonSolver(*this, newton_link_);
  if (settings_component_) {
    refuseSettingsBeside(*this, *settings_component_);
    const NewtonSettings own = settings_;
    settings_ = settings_component_->settings();
    settings_.stop_when_residual_grows = own.stop_when_residual_grows;
    settings_.forcing = own.forcing;
  }
  if (!data().find("forcing_term")->isSet()) takeUsualForcing(system, settings_);
  settings_.use_energy = haveEnergyInSolves(system), settings_.slow_factors = 1;
  // a limit that the scene writes is the only one
  settings_.patience = settings_component_ || data().find("newton_iterations")->isSet() ? 0 : 10;
  newton_.settings = settings_;
  newton_.compile(system.independentRows());
  problem_.compile(system), conditioned_.compile(system), sleep_.compile(system);
  if (!conditioned_.empty()) UncoupledConstraintCorrection::tellIdle(*this, "finds equilibria");
  force_.resize(system.independentRows()), good_.resize(system.independentRows());
  graph_.reserve(std::size_t(settings_.iterations) + 2);
  if (settings_component_) settings_component_->prepare(graph_.capacity());
}

/// False, with the sentence, when a body has no equilibrium where the step starts; or when it is asked to stop.
bool StaticSolver::checkFreeBodies(System& system, StopToken stop, StepReport& report) {
  problem_.giveUp(), problem_.setShare(1);
  problem_.residual(force_);
  report.stopped = stop.isStopAsked();
  if (report.stopped) return false;
  const std::string sentence = freeBody(system, force_);
  checked_revision_ = revisionOfHolds(system);
  is_checked_ = sentence.empty(), report.stopped = stop.isStopAsked();
  if (is_checked_ || report.stopped) return !report.stopped;
  report.reason = sentence, report.diverged = true;
  if (!conditioned_.empty())
    report.reason += fmt::format(
        ". What forces of constraint alone hold, as those of {}, is free here: AttachProjectiveConstraint ties it, or "
        "EulerImplicitSolver with rayleighMass brings it to rest",
        dynamic_cast<const Component&>(*system.actors().lagrangian_constraints.front()).path());
  return false;
}

StepReport StaticSolver::step(System& system, const StepContext& context) {
  if (sleep_.passesOver(context)) return {};
  clear(system.v);
  problem_.begin();
  StepReport report;
  const long held_before = std::exchange(held_, heldDirections(system.constraints()));
  if (!is_checked_ || held_ != held_before) {
    exact_.end();  // rigid motions are seen in the scene's tangent
    if (!checkFreeBodies(system, context.stop, report)) return report;
  }
  exact_.choose(system);
  const bool began_exact = exact_.isOn();
  report = solveInParts(system, context);
  if (began_exact && !report.stopped && (!report.newton_converged || report.diverged)) {
    // it helped before, and does not here
    exact_.end();
    problem_.giveUp();
    const StepReport before = std::exchange(report, solveInParts(system, context));
    addCounts(before, report);
  }
  if (report.stopped) return report;
  const bool tried_exact = exact_.isOn();
  if (exact_.endStep(report.newton_converged && !report.diverged)) problem_.residual(force_);
  exact_tangent_steps_ += exact_.isOn() && !began_exact;
  // what turns or comes and goes from step to step is looked at only where a solve has failed: it takes memory and time
  if (!report.newton_converged && settings_.iterations > 1 && revisionOfHolds(system) != checked_revision_) {
    const Rows x = system.independent(system.x);
    copy(x, good_);
    if (!checkFreeBodies(system, context.stop, report)) return report;
    copy(good_, x);
    problem_.residual(force_);
  }
  report.unsolved = !report.newton_converged;
  doubts_.noteStability(report, hasExactTangents(system), newton_.history(), context.t + context.dt);
  doubts_.noteUnmoved(report, settings_, [&] { return norm(system.independent(system.f)) > 3 * problem_.roundOff().residual; });
  if (report.unsolved && !report.diverged)
    report.reason += tried_exact ? "; with the exact tangent too" : exactTangentHint(system, report);
  graph_.assign(newton_.history().begin(), newton_.history().end());
  if (settings_component_) settings_component_->noteResult(report, newton_);
  if (report.unsolved && !settings_.keep_unconverged) problem_.giveUp(), report.reason += "; the state before the step was kept";
  return sleep_.judged(report);
}

/// One go at the share of the step that `context` ends with.
StepReport StaticSolver::solvePart(System& system, const StepContext& context) {
  return solveWithFollowers([&](StepReport& to) { return advancePrescribed(system, context, to); },
                            [&] { return newton_.solve(problem_, *solver_, context.stop); });
}

/// A part that fails with approximate tangents is tried again with the exact ones, which then serve the rest of the
/// step: from the best iterate, then from where the part began. One that is slow goes on with them, where they are symmetric.
StepReport StaticSolver::solveWithFallback(System& system, const StepContext& context) {
  newton_.settings.leaves_slow = triesMore() && exact_.mayBeFaster(system);
  StepReport report = solvePart(system, context);
  newton_.settings.leaves_slow = false;
  const auto isOver = [&report] { return report.stopped || (report.newton_converged && !report.diverged); };
  const auto goOn = [&] {
    const StepReport before = report;
    report = solvePart(system, context);
    addCounts(before, report);
  };
  if (!isOver() && newton_.wasSlow()) {
    const bool is_exact = exact_.beginForSpeed(system);
    goOn();
    if (is_exact && !isOver()) {
      exact_.end(), exact_.noteSlow();
      copy(good_, system.independent(system.x));
      goOn();
    }
  }
  if (isOver() || !triesMore() || !exact_.begin(system)) return report;
  for (const bool from_start : {false, true}) {
    if (isOver()) break;
    if (from_start) copy(good_, system.independent(system.x));
    goOn();
  }
  return report;
}

/// The whole step, or what it was divided into; see the top of this file.
StepReport StaticSolver::solveInParts(System& system, const StepContext& context) {
  constexpr double part_residual = 1e-4;
  const Rows x = system.independent(system.x);
  StepReport report, failed;
  if (!conditioned_.empty() && !is_free_) return solveConditions(system, context);
  double done = 0, part = 1;
  for (int parts = 1;; ++parts) {
    const double share = std::min(1.0, done + part);
    StepContext end = context;
    if (share < 1) end.t_end = context.t + share * context.dt;
    newton_.settings.relative_residual = share < 1 ? std::max(part_residual, settings_.relative_residual) : settings_.relative_residual;
    problem_.setShare(share);
    copy(x, good_);
    StepReport attempt = solveWithFallback(system, end);
    const bool good = attempt.newton_converged && !attempt.diverged;
    addCounts(report, attempt);
    report = attempt;
    report.load_parts = parts;
    if (report.stopped || (good && share == 1)) return report;
    if (good) {
      done = share, part *= 2;
      continue;
    }
    if (failed.reason.empty()) failed = attempt;
    if (!mayDivide() || part / 4 < smallest_part_) break;
    part /= 4;
    copy(good_, x);
    if (done == 0) problem_.setShare(1), problem_.keepStartForce();
  }
  if (report.load_parts == 1) return report;
  newton_.settings.relative_residual = settings_.relative_residual;
  const auto in_one_go = [&] { return solveWithFallback(system, context); };
  if (settings_.use_energy && solvesPatiently(newton_, problem_, x, good_, report, in_one_go)) return report;
  copy(good_, x), problem_.setShare(1);
  problem_.residual(force_);  // forces are those of the state that is left
  // moved nodes go to the end of a step whatever it has reached: the rest cannot stay behind
  report.diverged = (failed.diverged && done == 0) || system.constraints().hasPrescribed();
  report.newton_converged = false;
  report.reason = fmt::format(
      "{}; divided, the step reached an equilibrium under {:.3g} of its loads, and no part of {:.2g} beyond{}{}",
      failed.reason, done, part, report.reason.empty() ? "" : ": ", report.reason);
  return report;
}

/// What no force of constraint acts on goes its way as if there were none, and stands where it is in balance and the conditions hold.
StepReport StaticSolver::solveConditions(System& system, const StepContext& context) {
  StepReport tried;
  if (conditioned_.areFree()) {
    tried = whileOn(is_free_, [&] { return solveInParts(system, context); });
    if (tried.stopped || (tried.newton_converged && !tried.diverged && conditioned_.stayFree())) return tried;
    exact_.end(), problem_.giveUp(), problem_.setShare(1);
  }
  StepReport report = conditioned_.solveInParts(
      newton_, *solver_, context, [&](const StepContext& to, StepReport& of) { return advancePrescribed(system, to, of); },
      [&] { return triesMore() && exact_.begin(system); }, mayDivide() ? smallest_part_ : 1);
  addCounts(tried, report);
  return report;
}

/// Moves what has a prescribed motion to the end of the step; false when it is there. The rest is carried along by the
/// tangent where the step starts, -K du = f + K d with d the prescribed displacements: moved alone, a face would crush
/// the elements behind it. Where that costs more energy than moving it alone, it is moved alone.
bool StaticSolver::advancePrescribed(System& system, const StepContext& context, StepReport& report) {
  if (!system.constraints().hasPrescribed()) return false;
  for (Vector* vector : {&moved_v_, &displacement_}) provided(*vector, system.allRows());
  copy(system.x, provided(moved_, system.allRows()));
  system.constraints().placePrescribed(context, moved_, moved_v_);
  const Motion& motion = system.motion();
  const Rows x = system.independent(system.x), d = system.independent(displacement_);
  copy(x, d);
  motion.difference(system.independent(moved_), d);
  if (dot(d, d) <= 1e-30 * dot(x, x)) return false;
  // f + K d on all rows: the free ones see the prescribed displacement
  system.computeForceAndProduct(system.x, system.v, displacement_, {.stiffness = 1}, moved_v_);
  copy(system.independent(moved_v_), force_), clear(moved_v_);
  problem_.leaveOut(force_);
  if (!conditioned_.empty() && !is_free_) conditioned_.addCarried(force_);
  system.constraints().project(force_);
  const SolveTerms terms{settings_.forcing, context.stop};
  const bool solved = solveOrShift(*solver_, problem_.tangent(), force_, provided(mode_, x.count), terms, report);
  if (report.stopped || problem_.isBlocked(d, solved, mode_, report)) return true;
  motion.advance(1, d, x);
  const double alone = problem_.energy();
  double energy = alone;
  if (solved) {
    motion.advance(1, mode_, x);
    energy = problem_.energy();
    // moved alone, nodes may crush elements so far that they have no energy: any that exists is then better
    if (!std::isfinite(energy) || (settings_.use_energy && (conditioned_.empty() || is_free_) && energy > alone)) {
      motion.advance(-1, mode_, x);
      energy = alone;
    }
  }
  if (!std::isfinite(energy)) {
    report.newton_converged = false, report.reason = "the prescribed motion of the step crushes elements at once";
  }
  return true;
}

std::string StaticSolver::describe() const {
  return fmt::format("static equilibrium: up to {} Newton iterations to a relative residual of {:g}, line search on {}{}",
      settings_.iterations, settings_.relative_residual,
      settings_.use_energy ? "the potential energy" : "the work of the residual",
      mayDivide() ? fmt::format("; a step that fails is divided into parts of {:.2g} or more", smallest_part_) : "") +
      sleep_.describe();
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(static_solver) {
  factory.add<stroma::StaticSolver>("StaticSolver", "static equilibrium by Newton's method with line search");
}
