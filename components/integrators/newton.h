// SPDX-License-Identifier: LGPL-2.1-or-later
// Newton's method with line search on the unknowns of a system, for statics and for implicit steps; and the linear
// solve that does not give up on a matrix that is not definite.
#pragma once
#include <functional>
#include <vector>

#include "components/integrators/force_measure.h"
#include "framework/algebra/linear_solver.h"
#include "framework/simulation/step.h"
#include "framework/simulation/system.h"

namespace stroma {

/// What the rounding of positions and of sums alone changes at an iterate: less cannot be asked for.
struct RoundOff {
  double residual = 0;  ///< in |R|
  double energy = 0;    ///< in E, besides the round-off of its own sum
};

/// Equations R(u) = 0 seen from a current iterate u, which the problem holds. Where there is an energy, R = -grad E.
class LightBodies;
class NonlinearProblem {
 public:
  virtual ~NonlinearProblem() = default;
  virtual void residual(Rows out) = 0;  ///< R(u), projected; shape (rows)
  virtual SystemMatrix& tangent() = 0;  ///< -dR/du at the u of the last residual()
  /// The tangent of the next residual() has no unstable directions, as far as that is known, or is -dR/du again. False,
  /// and nothing changes, where there is no other.
  virtual bool useDefiniteTangent(bool) { return false; }
  /// Tangents may have unstable directions that they need not have, until takeSureTangent() for the rest of the step.
  virtual bool hasUnsureTangent() const { return false; }
  virtual void takeSureTangent() {}
  virtual double energy() = 0;  ///< E(u); called only when NewtonSettings::use_energy
  virtual Rows unknowns() = 0;  ///< u, for Newton to write; shape (rows)
  /// A direction that a linear solver has found, without what it has in directions that have been held since the solver kept
  /// what it starts from.
  virtual void keepToFree(Rows /*d*/) const {}
  /// d becomes a way from u to where the step may end, which is tried before the first iteration. False: none is known.
  virtual bool guess(Rows /*d*/) { return false; }
  virtual Rows sinceStart() { return unknowns(); }  ///< u less that where the step starts, for forces of constraint
  /// The largest s <= 1 up to which positions may move along d; nothing passes through anything before that.
  virtual double longestStep(ConstRows /*d*/) { return 1; }
  /// Something may stand in the way, whose energy has no bound where it is near: lines are searched to nearer their least energy.
  virtual bool meetsBarriers() const { return false; }
  /// Something may be met within the step that pushes from there on, and nothing tells of it before.
  virtual bool meetsWalls() const { return false; }
  /// The equations are solved at u with what was held fixed meanwhile. True: that has moved on, and they are others.
  virtual bool movesOn() { return false; }
  /// Something is moved from outside and has a way left, which goAlong() is to let it go before the next solve.
  virtual bool hasWay() { return false; }
  /// R becomes what it would be if it went all of that and nothing gave way, by the derivative at the last residual(). False, and
  /// nothing changes, where it would push nothing.
  virtual bool addPush(Rows /*residual*/) { return false; }
  /// It goes on along its way while u moves along d, both as far as nothing passes through anything; `wholly`: all of the way, or
  /// not at all, which is false. d is overwritten.
  virtual bool goAlong(Rows /*d*/, bool /*wholly*/ = false) { return true; }
  /// True: the equations will be others whatever the solution is, which is only a place to go on from.
  virtual bool isOnTheWay() { return false; }
  /// u moves by s d.
  virtual void addTo(Rows u, double s, ConstRows d) const { axpy(s, d, u); }
  /// The largest residual of parts that have a scale of their own, relative to that. A solve whose |R| is small goes on while this
  /// is not and halves.
  virtual double residualOfParts(ConstRows /*residual*/) const { return 0; }
  virtual LightBodies* lightBodies() { return nullptr; }    ///< null: it makes no difference between them
  virtual double weightOfForces() const { return 1; }  ///< R is that times forces
  virtual void unknownsChanged() = 0;                 ///< called after u was written
  virtual double displacementPerUnknown() const = 0;  ///< dx/du: 1, or seconds when u is a velocity
  virtual ConstRows positions() const = 0;            ///< x(u) [m]
  virtual void takeMeasure() {}  ///< where frames turn, sizes are those of the present tangent from now on
  virtual double sizeOf(ConstRows residual) const { return norm(residual); }  ///< |R|
  virtual double lengthOf(ConstRows d) const { return norm(d); }              ///< |d|
  virtual const Motion* motionOfFrames() const { return nullptr; }  ///< where some rows turn
  virtual double travelled() const = 0;               ///< |x(u) - x at the start| [m]
  /// The size of what R balances at the u of the last residual(), in R's unit: forces with the reactions of held nodes.
  virtual double loadScale() const = 0;
  /// True for equations of forces alone: where these are round-off there is nothing to do.
  virtual bool restsWithoutForces() const { return false; }
  /// The size of what acts besides the forces of bodies, in R's unit: gravity and fields without stiffness, now.
  virtual double loads() = 0;
  /// At the u of the last residual(). Costs a product with the tangent; asked for only where a solve gets no further.
  virtual RoundOff roundOff() = 0;
};

/// That of a system at its x, where positions cannot be told apart: |K p|, and p K p / 2 with that times the size of a cell, for a p of
/// one rounding error of each coordinate, with signs that follow no pattern of the mesh. `work`, `product`: shape (independentRows()).
RoundOff positionRoundOff(const System& system, const ForceMeasure& measure, Rows work, Rows product);

/// The size of the forces of gravity and of fields without stiffness at x. `work`: shape (allRows()).
double loadsOn(System& system, const ForceMeasure& measure, Rows work);

struct NewtonSettings {
  int iterations = 25;
  int patience =
      0;  ///< the solve is given up when |R| has not halved in so many iterations, the first 25 aside; 0: never
  bool leaves_slow = false;  ///< for callers with another tangent: a solve that converges by small factors is given up
  int slow_factors = 3;      ///< after so many of them, the first one of a solve aside
  /// |R| <= this * the larger of |R| and loadScale() where the solve starts, or loads() where that takes more than two iterations
  double relative_residual = 1e-8;
  double absolute_residual = 0;     ///< |R| <= this; 0: not used
  double successive_residual = 0;   ///< |R| <= this * |R| one iteration before; 0: not used
  double relative_correction = 0;   ///< |dx| <= this * travelled(); 0: not used. dx is the whole Newton correction,
  double absolute_correction = 0;   ///< |dx| <= this [m]; 0: not used.       however short the step along it was
  int line_search_iterations = 40;  ///< steps tried along a correction; 0: the whole one is made untested
  double line_search_coefficient = 0.5;  ///< a step that is refused is shortened at least by this
  bool use_energy = true;                ///< line search on the energy (Armijo), else on the work R.d
  bool looks_for_unstable_modes = false;  ///< once, close to the solution, where the linear solver does not tell: isUnstable()
  bool restores_soft_directions = false;  ///< see ShiftTerms::soft_directions
  /// Largest relative residual that a linear solve by products may leave, and leaves in the first iteration; then 0.9
  /// times the square of the last reduction of |R| (Eisenstat and Walker 1996, choice 2). 0: the solver's tolerance.
  double forcing = 0;
  bool is_linear = false;  ///< without a forcing: what round-off left of a solve is solved to the end of the step, no further
  /// A solve that would leave less than `forcing_reach` times the residual that ends the iteration leaves `forcing_margin` times
  /// that: less is wasted, and a little more would cost an iteration.
  double forcing_reach = 0.5, forcing_margin = 0.5;
  bool stop_when_residual_grows = false;
  bool keep_unconverged = true;  ///< for callers: an iterate that has not converged becomes the state
  bool fixed_count = false;      ///< where `iterations` end is the result, unless |R| is little before
};

/// d without what it has in directions that are held, where these may have changed since a solver kept what it starts from.
void keepToFree(const System& system, Rows d);

/// What solveOrShift() does with a matrix that is not positive definite.
struct ShiftTerms {
  std::function<SystemMatrix*()> other{};  ///< another matrix to put in its place before anything is added; may be empty or return null
  bool once = false;                       ///< return false where the solve is not usable, and try nothing else
  /// The system, where x is the result of a linear step and not only a direction: what is unstable is first turned over, see
  /// ShiftedMatrix.
  const System* result = nullptr;
  bool soft_directions = false;  ///< where factors were made, soft directions get back what the shift takes (soft_directions.h)
};

/// Solves A x = b; x enters as zero. When the solver reports a matrix that is not positive definite, the direction it
/// has reached is kept if it goes downhill. Else a growing multiple of the matrix's own diagonal is added (Levenberg) until the solve
/// is usable. x is then usable too, and a reason says so. Adds to the counts of `report`; its linear_stop is the first solve's, so a
/// shift stays visible. False when nothing helped, `report` then carries the sentence, or when it was stopped.
bool solveOrShift(LinearSolver& solver, SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms, StepReport& report,
                  const ShiftTerms& shift_terms = {});

class Newton {
 public:
  NewtonSettings settings;

  void compile(Index rows);
  /// From the problem's current iterate to a root. Not converging leaves a reason and the best iterate: the last one where the line
  /// search is on the energy, which never rises, unless there are barriers and |R| is above its scale; else the one of the smallest
  /// |R| after the first iteration. `diverged` is set when no usable iterate exists. A stop is heeded between force evaluations and
  /// within the linear solves.
  StepReport solve(NonlinearProblem& problem, LinearSolver& solver, StopToken stop);
  /// |R| before each iteration and after the last one, of the last solve().
  const std::vector<double>& history() const { return history_; }
  /// Whether the last solve() was given up because it was slow. The next one then goes on from there.
  bool wasSlow() const { return was_slow_; }
  /// A mode was found in the last solve(), close to its end, along which the tangent pushes on.
  bool isUnstable() const { return is_unstable_; }
  /// The last solve() ended before an iteration came close to its solution, with which a solver or isUnstable() tells of such a mode.
  bool hasNotLooked() const;
  /// The next solve begins where the last one has left the unknowns, and its tolerance is of where that one began.
  void keepScale() { keeps_scale_ = true; }
  double iterationsLeft() const;  ///< of a solve that was given up so
  std::vector<double>& history() { return history_; }  ///< for a caller that makes the iterations itself

 private:
  StepReport solveFixed(NonlinearProblem& problem, LinearSolver& solver);
  StepReport solveAll(NonlinearProblem& problem, LinearSolver& solver);
  class Focus;
  void solveBody(NonlinearProblem& problem, LinearSolver& solver, LightBodies& bodies, StepReport& report);
  void takeScale(NonlinearProblem& problem, double norm);
  void goAlong(NonlinearProblem& problem, LinearSolver& solver, StepReport& report);
  bool converged(double norm) const;
  bool isForParts(const NonlinearProblem& problem, double norm);
  bool isLeftAsItWas(double norm, StepReport& report) const;
  double goal() const;
  double forcingTerm(double norm) const;
  bool isCorrectionSmall(const NonlinearProblem& problem) const;
  bool isCorrectionWithin(double part, const NonlinearProblem& problem) const;
  bool isPointless() const;
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
  /// A length along the direction that was refused, and the work R.d that it leaves.
  struct Refused {
    double step = 0, left = 0;
  };
  double shorter(double step, double left, double slope, Refused& before) const;

  Vector residual_, direction_, trial_;
  Vector base_, best_;  ///< the iterate that move() starts from; the one that is left when nothing converges
  std::vector<double> history_;
  StopToken stop_;        ///< of the last solve()
  double enough_ = 0;     ///< |R| of a solution that is only a place to go on from; else 0
  double scale_ = 0;      ///< what the relative residual is relative to
  double best_norm_ = 0;  ///< |R| of best_
  double parts_ = 0;      ///< residualOfParts() at the last iteration that was made for these; infinity: none was
  bool was_slow_ = false, went_on_ = false;  ///< went on: with another tangent, whose first direction is to be found
  bool keeps_scale_ = false;  ///< see keepScale()
  bool is_unstable_ = false, has_looked_ = false;  ///< see lookForUnstableMode()
  bool in_focus_ = false;     ///< one of the problem's bodies is solved for
  bool is_unsure_ = false;    ///< the direction is of a tangent that may have unstable directions that it need not have
};

}  // namespace stroma
