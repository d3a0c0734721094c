// SPDX-License-Identifier: LGPL-2.1-or-later
// Newton's method with line search on the unknowns of a system, for statics and for implicit steps; and a linear
// solve that handles indefinite matrices.
#pragma once
#include <functional>
#include <vector>

#include "components/integrators/force_measure.h"
#include "framework/algebra/linear_solver.h"
#include "framework/simulation/step.h"
#include "framework/simulation/system.h"

namespace stroma {

/// The effect of rounding positions and sums at an iterate: a smaller change is not attainable.
struct RoundOff {
  double residual = 0;  ///< in |R|
  double energy = 0;    ///< in E, in addition to the round-off of its sum
};

/// Equations R(u) = 0 at a current iterate u, which the problem stores. If there is an energy, R = -grad E.
class LightBodies;
class NonlinearProblem {
 public:
  virtual ~NonlinearProblem() = default;
  virtual void residual(Rows out) = 0;  ///< R(u), projected; shape (rows)
  virtual SystemMatrix& tangent() = 0;  ///< -dR/du at the u of the last residual()
  /// Switches the tangent of the next residual() to one without unstable directions, as far as known, or back to -dR/du. Returns
  /// false and changes nothing if there is no other.
  virtual bool useDefiniteTangent(bool) { return false; }
  /// Tangents may have avoidable unstable directions, until excludeUnstableDirections() excludes them for the rest of the step.
  virtual bool mayHaveUnstableDirections() const { return false; }
  virtual void excludeUnstableDirections() {}
  /// Uses a damping without unstable directions, from the next residual() on for the rest of the step. Returns false and changes nothing
  /// if it does already, or if there is no other.
  virtual bool useDefiniteDamping() { return false; }
  virtual double energy() = 0;  ///< E(u); called only when NewtonSettings::use_energy
  virtual Rows unknowns() = 0;  ///< u, for Newton to write; shape (rows)
  /// Removes from a solver's direction the part in directions that have been fixed since the solver stored its initial
  /// guess.
  virtual void projectToFree(Rows /*d*/) const {}
  /// Sets d to a guess of the way from u to the end of the step, which is tried before the first iteration. Returns false if none is known.
  virtual bool guess(Rows /*d*/) { return false; }
  virtual Rows changeSinceStart() { return unknowns(); }  ///< u minus its value at the start of the step, for constraint forces
  /// The largest s <= 1 for which positions may move along d without anything passing through anything else.
  virtual double longestStep(ConstRows /*d*/) { return 1; }
  /// There may be obstacles with an unbounded energy nearby: line searches then go closer to the minimum of the energy.
  virtual bool mayMeetBarriers() const { return false; }
  /// Contact may begin within the step without earlier notice, as with penalties.
  virtual bool mayMeetPenalties() const { return false; }
  /// The equations are solved at u with lagged quantities. Returns true if those were updated, so that the equations have changed.
  virtual bool updatesLagged() { return false; }
  /// A prescribed motion has a remaining way, which advanceRemainingMotion() must advance before the next solve.
  virtual bool hasRemainingMotion() { return false; }
  /// Sets R to its value after that motion with all nodes fixed, by the derivative at the last residual(). Returns false and changes
  /// nothing if the motion would push nothing.
  virtual bool addPush(Rows /*residual*/) { return false; }
  /// Advances the motion while u moves along d, both as far as nothing passes through anything; `wholly`: completely, or not at all
  /// and returns false. d is overwritten.
  virtual bool advanceRemainingMotion(Rows /*d*/, bool /*wholly*/ = false) { return true; }
  /// True: the equations will change whatever the solution is, so it is only intermediate.
  virtual bool isIntermediate() { return false; }
  /// Moves u by s d.
  virtual void addTo(Rows u, double s, ConstRows d) const { axpy(s, d, u); }
  /// The largest relative residual of parts with separate scales. A solve whose |R| is small continues while this is large and
  /// halves.
  virtual double residualOfParts(ConstRows /*residual*/) const { return 0; }
  virtual LightBodies* lightBodies() { return nullptr; }    ///< null: no distinction between bodies
  virtual double weightOfForces() const { return 1; }  ///< R is that times forces
  virtual void unknownsChanged() = 0;                 ///< called after u was written
  virtual double displacementPerUnknown() const = 0;  ///< dx/du: 1, or seconds when u is a velocity
  virtual ConstRows positions() const = 0;            ///< x(u) [m]
  virtual void updateNorms() {}  ///< updates the norms of frames with the present tangent
  virtual double sizeOf(ConstRows residual) const { return norm(residual); }  ///< |R|
  virtual double lengthOf(ConstRows d) const { return norm(d); }              ///< |d|
  virtual const Motion* motionOfFrames() const { return nullptr; }  ///< if some rows are orientations
  virtual double travelled() const = 0;               ///< |x(u) - x at the start| [m]
  /// The magnitude of the forces balanced in R at the u of the last residual(), in R's unit: forces including reactions of fixed nodes.
  virtual double loadScale() const = 0;
  /// True for equations of forces only: nothing needs to be solved if they are round-off.
  virtual bool isForceBalance() const { return false; }
  /// The magnitude of loads in R's unit: gravity and fields without stiffness, at present.
  virtual double loads() = 0;
  /// At the u of the last residual(). Costs a product with the tangent; called only if a solve stagnates.
  virtual RoundOff roundOff() = 0;
};

/// The round-off of a system at its x: |K p|, and p K p / 2 plus that times the size of a cell, for a p with one rounding error per
/// coordinate and signs independent of the pattern of the mesh. `work`, `product`: shape (independentRows()).
RoundOff positionRoundOff(const System& system, const ForceMeasure& measure, Rows work, Rows product);

/// The magnitude of gravity and of fields without stiffness at x. `work`: shape (allRows()).
double loadsOn(System& system, const ForceMeasure& measure, Rows work);

struct NewtonSettings {
  int iterations = 25;
  int patience =
      0;  ///< the solve is abandoned if |R| has not halved in this many iterations, not counting the first 25; 0: never
  bool leaves_slow = false;  ///< for callers with another tangent: a slowly converging solve is abandoned
  int slow_factors = 3;      ///< after this many slow iterations, not counting the first of a solve
  /// |R| <= this * the larger of |R| and loadScale() at the start of the solve, or loads() if that takes more than two iterations
  double relative_residual = 1e-8;
  double absolute_residual = 0;     ///< |R| <= this; 0: not used
  double successive_residual = 0;   ///< |R| <= this * |R| one iteration before; 0: not used
  double relative_correction = 0;   ///< |dx| <= this * travelled(); 0: not used. dx is the whole Newton correction,
  double absolute_correction = 0;   ///< |dx| <= this [m]; 0: not used.       however short the step along it was
  int line_search_iterations = 40;  ///< steps tried along a correction; 0: the whole one is made untested
  double line_search_coefficient = 0.5;  ///< a rejected step is shortened at least by this factor
  bool use_energy = true;                ///< line search on the energy (Armijo), otherwise on the work R.d
  bool looks_for_unstable_modes = false;  ///< once, close to the solution, if the linear solver does not reveal them: isUnstable()
  bool restores_soft_directions = false;  ///< see ShiftTerms::soft_directions
  /// Largest relative residual of an iterative linear solve, used in the first iteration; then 0.9 times the square of the
  /// last reduction of |R| (Eisenstat and Walker 1996, choice 2). 0: the solver's tolerance.
  double forcing = 0;
  bool is_linear = false;  ///< without a forcing term: only the round-off of a solve is corrected, to the tolerance of the step
  /// A solve that would leave less than `forcing_reach` times the final residual of the iteration leaves `forcing_margin` times
  /// that: less is wasted, and slightly more would cost an iteration.
  double forcing_reach = 0.5, forcing_margin = 0.5;
  bool stop_when_residual_grows = false;
  bool keep_unconverged = true;  ///< for callers: an unconverged iterate becomes the state
  bool fixed_count = false;      ///< the iterate after `iterations` is the result, unless |R| is small earlier
};

/// Removes the part of d in fixed directions, which may have changed since a solver stored its initial guess.
void projectToFree(const System& system, Rows d);

/// How solveOrShift() handles an indefinite matrix.
struct ShiftTerms {
  std::function<SystemMatrix*()> other{};  ///< another matrix to try before anything is added; may be empty or return null
  bool once = false;                       ///< return false if the first solve is not usable, without further attempts
  /// The system if x is the result of a linear step rather than a direction: unstable directions are then first reflected, see
  /// ShiftedMatrix.
  const System* result = nullptr;
  bool soft_directions = false;  ///< with factors, the effect of the shift on soft directions is removed (soft_directions.h)
};

/// Solves A x = b; x is zero on entry. If the solver reports an indefinite matrix, its present direction is kept if it is a
/// descent direction. Otherwise a growing multiple of the matrix diagonal is added (Levenberg) until the solve is usable; a reason
/// reports this. Adds to the counts of `report`; its linear_stop is that of the first solve, so a shift remains visible. Returns
/// false if nothing helped, with the message in `report`, or if it was stopped.
bool solveOrShift(LinearSolver& solver, SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms, StepReport& report,
                  const ShiftTerms& shift_terms = {});

class Newton {
 public:
  NewtonSettings settings;

  void compile(Index rows);
  /// Iterates from the problem's current iterate to a root. Without convergence it leaves a reason and the best iterate: the last one
  /// with a line search on the energy, which never increases, unless there are barriers and |R| is above its scale; otherwise the one
  /// with the smallest |R| after the first iteration. `diverged` is set if there is no usable iterate. Stop requests are checked between
  /// force evaluations and within linear solves.
  StepReport solve(NonlinearProblem& problem, LinearSolver& solver, StopToken stop);
  /// |R| before each iteration and after the last one, of the last solve().
  const std::vector<double>& history() const { return history_; }
  /// Whether the last solve() was abandoned because it was slow. The next one then continues from there.
  bool wasSlow() const { return was_slow_; }
  /// A mode was found in the last solve(), close to its end, along which the tangent is unstable.
  bool isUnstable() const { return is_unstable_; }
  /// The last solve() ended before any iteration was close enough to the solution for a solver or isUnstable() to reveal such a mode.
  bool shouldLookForUnstableMode() const;
  /// The next solve starts from the unknowns of the last one, with the same tolerance.
  void keepScale() { keeps_scale_ = true; }
  double iterationsLeft() const;  ///< estimate for an abandoned solve
  std::vector<double>& history() { return history_; }  ///< for a caller that makes the iterations itself

 private:
  StepReport solveFixed(NonlinearProblem& problem, LinearSolver& solver);
  StepReport solveAll(NonlinearProblem& problem, LinearSolver& solver);
  class Focus;
  void solveBody(NonlinearProblem& problem, LinearSolver& solver, LightBodies& bodies, StepReport& report);
  void takeScale(NonlinearProblem& problem, double norm);
  void advanceRemainingMotion(NonlinearProblem& problem, LinearSolver& solver, StepReport& report);
  bool converged(double norm) const;
  bool isForParts(const NonlinearProblem& problem, double norm);
  bool isLeftAsItWas(double norm, StepReport& report) const;
  double goal() const;
  double forcingTerm(double norm) const;
  bool isCorrectionSmall(const NonlinearProblem& problem) const;
  bool isCorrectionWithin(double part, const NonlinearProblem& problem) const;
  bool isPointless() const;
  bool mayBeDriven() const;
  bool isAtRoundOff(NonlinearProblem& problem, double norm, StepReport& report);
  bool isAtRest(NonlinearProblem& problem);
  bool findDirection(NonlinearProblem& problem, LinearSolver& solver, double tolerance, StepReport& report);
  bool iterate(NonlinearProblem& problem, LinearSolver& solver, double& norm, StepReport& report);
  void lookForUnstableMode(NonlinearProblem& problem, LinearSolver& solver, double norm, StepReport& report);
  void goToGuess(NonlinearProblem& problem, double& norm);
  void keepIfBest(NonlinearProblem& problem, double norm);
  void leaveBest(NonlinearProblem& problem, double norm, StepReport& report);
  void move(NonlinearProblem& problem, double step);
  double search(NonlinearProblem& problem, double& norm);
  double searchSurely(NonlinearProblem& problem, LinearSolver& solver, double tolerance, double& norm, StepReport& report);
  double searchEnergy(NonlinearProblem& problem, double longest, double slope, double& norm);
  double lengthen(NonlinearProblem& problem, double step, double refused, double before, double slope, double& norm);
  void goOn(NonlinearProblem& problem, double slope, double& norm);
  double searchWork(NonlinearProblem& problem, double longest, double& norm);
  /// A rejected length along the direction, and the work R.d that it leaves.
  struct Refused {
    double step = 0, left = 0;
  };
  double shorter(double step, double left, double slope, Refused& before) const;

  Vector residual_, direction_, trial_;
  Vector base_, best_;  ///< the iterate that move() starts from; the one that is kept without convergence
  std::vector<double> history_;
  StopToken stop_;        ///< of the last solve()
  double enough_ = 0;     ///< sufficient |R| of an intermediate solution; otherwise 0
  double scale_ = 0;      ///< the scale of the relative residual
  double best_norm_ = 0;  ///< |R| of best_
  double parts_ = 0;      ///< residualOfParts() at the last iteration made because of it; infinity: none
  bool was_slow_ = false, went_on_ = false;  ///< went_on_: with another tangent, whose first direction is not known yet
  bool keeps_scale_ = false;  ///< see keepScale()
  bool is_unstable_ = false, has_looked_ = false;  ///< see lookForUnstableMode()
  bool in_focus_ = false;     ///< one of the problem's bodies is being solved separately
  int unstable_solves_ = 0;   ///< linear solves of the last solve() that showed unstable directions
  bool is_replaced_ = false;  ///< the direction comes from a definite tangent instead of an indefinite one
  bool is_unsure_ = false;    ///< the direction comes from a tangent that may have avoidable unstable directions
};

}  // namespace stroma
