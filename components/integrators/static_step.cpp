// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/integrators/static_step.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "components/integrators/while_on.h"

namespace stroma {
namespace {

bool isOver(const StepReport& report) { return report.stopped || (report.newton_converged && !report.diverged); }

}  // namespace

void StaticStep::compile(System& system, LinearSolver& solver) {
  system_ = &system, solver_ = &solver;
  newton.settings = settings_;
  newton.compile(system.independentRows());
  problem.compile(system), conditioned.compile(system);
  force_.resize(system.independentRows()), good_.resize(system.independentRows());
}

StepReport StaticStep::solve(const StepContext& context) { return hasConditions() ? solveConditions(context) : solveForces(context); }

/// One go at the share of the step that `context` ends with.
StepReport StaticStep::solvePart(const StepContext& context) {
  return solveWithFollowers([&](StepReport& to) { return advancePrescribed(context, to); },
                            [&] { return newton.solve(problem, *solver_, context.stop); });
}

/// A part that fails with approximate tangents is tried again with the exact ones, which then serve the rest of the
/// step: from the best iterate, then from where the part began. One that is slow goes on with them, where they are symmetric.
StepReport StaticStep::solveWithFallback(const StepContext& context) {
  newton.settings.leaves_slow = triesMore() && exact.mayBeFaster(*system_);
  StepReport report = solvePart(context);
  newton.settings.leaves_slow = false;
  const auto goOn = [&] {
    const StepReport before = report;
    report = solvePart(context);
    addCounts(before, report);
  };
  if (!isOver(report) && newton.wasSlow()) {
    const bool is_exact = exact.beginForSpeed(*system_);
    goOn();
    if (is_exact && !isOver(report)) {
      exact.end(), exact.noteSlow();
      copy(good_, x());
      goOn();
    }
  }
  if (isOver(report) || !triesMore() || !exact.begin(*system_)) return report;
  for (const bool from_start : {false, true}) {
    if (isOver(report)) break;
    if (from_start) copy(good_, x());
    goOn();
  }
  return report;
}

/// The whole step, or what it was divided into; see static_step.h.
StepReport StaticStep::solveForces(const StepContext& context) {
  constexpr double part_residual = 1e-4;
  struct Whole {  // whatever ends the step, the next one is whole
    StaticStep& step;
    ~Whole() { step.newton.settings.relative_residual = step.settings_.relative_residual, step.problem.setShare(1); }
  } whole{*this};
  StepReport report, failed;
  double done = 0, part = 1;
  for (int parts = 1;; ++parts) {
    const double share = std::min(1.0, done + part);
    StepContext end = context;
    if (share < 1) end.t_end = context.t + share * context.dt;
    newton.settings.relative_residual = share < 1 ? std::max(part_residual, settings_.relative_residual) : settings_.relative_residual;
    problem.setShare(share);
    copy(x(), good_);
    StepReport attempt = solveWithFallback(end);
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
    copy(good_, x());
    if (done == 0) problem.setShare(1), problem.keepStartForce();
  }
  if (report.load_parts == 1) return report;
  newton.settings.relative_residual = settings_.relative_residual;
  if (settings_.use_energy && solvePatiently(context, report)) return report;
  copy(good_, x()), problem.setShare(1);
  problem.residual(force_);  // forces are those of the state that is left
  // moved nodes go to the end of a step whatever it has reached: the rest cannot stay behind
  report.diverged = (failed.diverged && done == 0) || system_->constraints().hasPrescribed();
  report.newton_converged = false;
  report.reason = fmt::format(
      "{}; divided, the step reached an equilibrium under {:.3g} of its loads, and no part of {:.2g} beyond{}{}",
      failed.reason, done, part, report.reason.empty() ? "" : ": ", report.reason);
  return report;
}

/// A step that has failed in all its parts, once more from its start, in one go. True when that ends the step, as `report` then says;
/// else good_ is what it was.
bool StaticStep::solvePatiently(const StepContext& context, StepReport& report) {
  const int patience = std::exchange(newton.settings.patience, 0);
  if (patience == 0) return false;
  Vector reached(good_.count());
  copy(good_, reached);
  problem.giveUp(), problem.setShare(1);
  copy(x(), good_);
  StepReport last = solveWithFallback(context);
  newton.settings.patience = patience;
  const int parts = report.load_parts;
  if (isOver(last)) {
    addCounts(std::exchange(report, last), report);
    report.load_parts = parts;
    return true;
  }
  addCounts(last, report);
  report.reason += "; once more in one go: " + last.reason + " (a larger newton_iterations goes on)";
  copy(reached, good_);
  return false;
}

/// What no force of constraint acts on goes its way as if there were none, and stands where it is in balance and the conditions hold.
StepReport StaticStep::solveConditions(const StepContext& context) {
  StepReport tried;
  if (conditioned.areFree()) {
    tried = whileOn(is_free_, [&] { return solveForces(context); });
    if (tried.stopped || (tried.newton_converged && !tried.diverged && conditioned.stayFree())) return tried;
    exact.end(), problem.giveUp(), problem.setShare(1);
  }
  StepReport report = conditioned.solveInParts(
      newton, *solver_, context, [&](const StepContext& to, StepReport& of) { return advancePrescribed(to, of); },
      [&] { return triesMore() && exact.begin(*system_); }, mayDivide() ? smallest_part_ : 1);
  addCounts(tried, report);
  return report;
}

/// Moves what has a prescribed motion to the end of the step; false when it is there. The rest is carried along by the
/// tangent where the step starts, -K du = f + K d with d the prescribed displacements: moved alone, a face would crush
/// the elements behind it.
bool StaticStep::advancePrescribed(const StepContext& context, StepReport& report) {
  System& system = *system_;
  if (!system.constraints().hasPrescribed()) return false;
  for (Vector* vector : {&moved_v_, &displacement_}) provided(*vector, system.allRows());
  copy(system.x, provided(moved_, system.allRows()));
  system.constraints().placePrescribed(context, moved_, moved_v_);
  const Rows d = system.independent(displacement_);
  copy(x(), d);
  system.motion().difference(system.independent(moved_), d);
  if (dot(d, d) <= 1e-30 * dot(x(), x())) return false;
  // f + K d on all rows: the free ones see the prescribed displacement
  system.computeForceAndProduct(system.x, system.v, displacement_, {.stiffness = 1}, moved_v_);
  copy(system.independent(moved_v_), force_), clear(moved_v_);
  problem.leaveOut(force_);
  if (hasConditions()) conditioned.addCarried(force_);
  system.constraints().project(force_);
  const SolveTerms terms{settings_.forcing, context.stop};
  const bool is_solved = solveOrShift(*solver_, problem.tangent(), force_, provided(mode_, x().count), terms, report);
  if (report.stopped || problem.isBlocked(d, is_solved, mode_, report)) return true;
  if (!carryAlong(d, is_solved))
    report.newton_converged = false, report.reason = "the prescribed motion of the step crushes elements at once";
  return true;
}

/// Moves x by d and, if that has an energy at all or costs less than d alone, by the solution of the rest. False where neither has one.
bool StaticStep::carryAlong(ConstRows d, bool is_solved) {
  const Motion& motion = system_->motion();
  motion.advance(1, d, x());
  const double alone = problem.energy();
  double energy = alone;
  if (is_solved) {
    motion.advance(1, mode_, x());
    energy = problem.energy();
    // moved alone, nodes may crush elements so far that they have no energy: any that exists is then better
    if (!std::isfinite(energy) || (settings_.use_energy && !hasConditions() && energy > alone)) {
      motion.advance(-1, mode_, x());
      energy = alone;
    }
  }
  return std::isfinite(energy);
}

}  // namespace stroma
