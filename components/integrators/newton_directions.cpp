// SPDX-License-Identifier: LGPL-2.1-or-later
// The linear solves of Newton's method, and the treatment of indefinite matrices.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <cmath>
#include <utility>

#include "components/integrators/light_bodies.h"
#include "components/integrators/newton.h"
#include "components/integrators/shifted_matrix.h"
#include "components/integrators/soft_directions.h"
#include "components/integrators/whole_matrix.h"
#include "framework/scene/spans.h"
#include "framework/simulation/step_watch.h"

namespace stroma {
namespace {

SolveReport solveOnce(LinearSolver& solver, SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms,
                      StepReport& report) {
  const auto start = std::chrono::steady_clock::now();
  Span span("solve", &solver);
  const SolveReport solve = solveWhole(solver, matrix, b, x, terms);
  if (stepWatch()) stepWatch()->solved(matrix, b, x);
  report.stopped = report.stopped || solve.stop == SolveStop::stopped;
  report.solve_seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  span.count(solve.iterations);
  report.linear_iterations += solve.iterations;
  report.factorisations += solve.factored;
  report.linear_residual = solve.relative_residual;
  return solve;
}

std::string placeOf(const SolveReport& solve, const SystemMatrix& matrix) {
  return solve.row >= 0 ? " at " + matrix.describeRow(solve.row) : std::string();
}

/// A solve that ended for a reason that lies in the matrix has no result to rely on.
bool isSolved(const SolveReport& solve) { return solve.usable() && solve.stop != SolveStop::breakdown; }

using Turns = ShiftedMatrix::Turns;

std::string changeOf(const ShiftedMatrix& matrix, double shift, bool is_result) {
  std::string change;
  if (matrix.turned() > 0) change = fmt::format("; what is unstable in {} of its {} rows was turned over", matrix.turned(), matrix.rows());
  if (shift > 0) change += fmt::format("; {:g} times its diagonal was added", shift);
  return shift > 0 && is_result ? change + ", which weakens the forces of the step" : change;
}

/// With what is unstable turned over; where that does not help, x stays as it is.
bool solveStably(LinearSolver& solver, SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms, StepReport& report,
                 const System& system) {
  Vector found(x.count);
  copy(x, found);
  for (const Turns turns : {Turns::unstable_blocks, Turns::unstable_rows}) {
    ShiftedMatrix stable(matrix, turns, &system);
    if (stable.turned() == 0) continue;
    clear(x);
    const bool is_solved = isSolved(solveOnce(solver, stable, b, x, terms, report));
    if (is_solved) report.reason += changeOf(stable, 0, true);
    if (is_solved || report.stopped) return is_solved;
  }
  copy(found, x);
  return false;
}

}  // namespace

void projectToFree(const System& system, Rows d) {
  const ConstraintSet& constraints = system.constraints();
  if (constraints.change() || constraints.revision() > 1) constraints.project(d);
}

bool solveOrShift(LinearSolver& solver, SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms,
                  StepReport& report, const ShiftTerms& shift_terms) {
  const System* const result = shift_terms.result;
  clear(x);
  SolveReport solve = solveOnce(solver, matrix, b, x, terms, report);
  report.linear_stop = solve.stop;
  if (report.stopped) return false;
  report.linear_at_limit =
      report.linear_at_limit || solve.stop == SolveStop::iteration_limit || solve.stop == SolveStop::stagnated;
  report.linear_converged =
      report.linear_converged && (solve.stop == SolveStop::converged || solve.stop == SolveStop::zero_right_side);
  if (isSolved(solve)) {
    if (result && solve.stop == SolveStop::converged && result->states().size() > 1)
      solveLightBodies(*result, solver, matrix, b, x, terms, report);
    return !report.stopped;
  }
  if (shift_terms.once) return false;
  if (solve.stop != SolveStop::not_finite) {
    report.reason =
        fmt::format("the linear solver {} {}{}", solver.path(), describe(solve.stop), placeOf(solve, matrix));
    const double downhill = dot(b, x);
    if (result && solveStably(solver, matrix, b, x, terms, report, *result)) return true;
    if (report.stopped) return false;
    if (downhill > 0 && std::isfinite(downhill)) {
      report.reason += "; the direction found before was used";
      return true;
    }
    if (SystemMatrix* const definite = shift_terms.other ? shift_terms.other() : nullptr) {
      clear(x);
      solve = solveOnce(solver, *definite, b, x, terms, report);
      if (report.stopped) return false;
      if (isSolved(solve)) {
        report.reason += "; a stiffness without its unstable part was used";
        return true;
      }
    }
    ShiftedMatrix shifted(matrix, result ? Turns::unstable_rows : Turns::none, result);
    double shift = 1e-3;
    for (int attempt = 0; attempt < 7; ++attempt, shift *= 10) {
      shifted.setShift(shift);
      clear(x);
      solve = solveOnce(solver, shifted, b, x, terms, report);
      if (report.stopped) return false;
      if (isSolved(solve)) {
        report.reason += changeOf(shifted, shift, result);
        if (shift_terms.soft_directions && solve.factored) restoreSoftDirections(solver, shifted, shift, b, x, terms, report);
        return !report.stopped;
      }
    }
  }
  report.diverged = true;
  report.linear_stop = solve.stop;
  report.reason = fmt::format("the linear solver {} {}{}", solver.path(), describe(solve.stop), placeOf(solve, matrix));
  return false;
}

/// Where the tangent has unstable directions: a body that is nearly incompressible is under pressures far above its
/// stress, of either sign, while iterates are off by a little of their volume. The next force has the scene's tangent.
bool Newton::findDirection(NonlinearProblem& problem, LinearSolver& solver, double tolerance, StepReport& report) {
  bool switched = false;
  const auto definite = [&]() -> SystemMatrix* {
    switched = problem.useDefiniteTangent(true);
    if (!switched) return nullptr;
    problem.residual(trial_);
    return &problem.tangent();
  };
  const auto solve = [&](bool once) {  // a reference: a copy would be taken from the heap in each iteration
    return solveOrShift(solver, problem.tangent(), residual_, direction_, {tolerance, stop_}, report,
                        {.other = std::ref(definite), .once = once, .soft_directions = settings.restores_soft_directions});
  };
  const bool converged = report.linear_converged, at_limit = report.linear_at_limit;
  is_unsure_ = problem.mayHaveUnstableDirections();
  bool found = solve(is_unsure_);
  // many solvers do not see that a matrix is not definite
  const bool is_bad = is_unsure_ && !report.stopped && !(found && dot(residual_, direction_) > 0);
  if (is_bad) {
    problem.excludeUnstableDirections();
    is_unsure_ = false, report.linear_converged = converged, report.linear_at_limit = at_limit;
    found = solve(false);
  }
  unstable_solves_ += report.linear_stop == SolveStop::not_definite || !(dot(residual_, direction_) > 0);
  problem.projectToFree(direction_);
  if (switched) problem.useDefiniteTangent(false);
  is_replaced_ = switched;
  went_on_ = false;
  return found;
}

/// An iteration is close to the solution, and its tangent shows unstable modes there.
static bool comesClose(double now, double first) { return now < 1e-2 * first; }

bool Newton::shouldLookForUnstableMode() const {
  return !has_looked_ && (history_.size() < 2 || !comesClose(history_[history_.size() - 2], history_.front()));
}

/// With the factors of the direction that was just found. Solvers of symmetric matrices tell by themselves.
void Newton::lookForUnstableMode(NonlinearProblem& problem, LinearSolver& solver, double now, StepReport& report) {
  if (has_looked_ || solver.needsSymmetric() || report.factorisations == 0 || !comesClose(now, history_.front())) return;
  has_looked_ = true;
  is_unstable_ = hasUnstableMode(solver, problem.tangent(), {.stop = stop_}, report);
}

/// The line search. Where it finds no decrease along the direction of a tangent that may be unstable, it has that of the sure one.
double Newton::searchSurely(NonlinearProblem& problem, LinearSolver& solver, double tolerance, double& now, StepReport& report) {
  const double step = search(problem, now);
  if (step > 0 || !is_unsure_ || stop_.isStopAsked()) return step;
  problem.excludeUnstableDirections();
  problem.residual(residual_);  // derivatives are those of the last one
  return findDirection(problem, solver, tolerance, report) ? search(problem, now) : 0;
}

}  // namespace stroma
