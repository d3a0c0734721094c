// SPDX-License-Identifier: LGPL-2.1-or-later
// Forces of Lagrangian constraints in an implicit step. The unconstrained step has found u, with its matrix A of A du = b.
// Impulses p = weight l along the gradients J then change
//   u by c = A^-1 J^T p,   x by displacement c,   conditions g(x) by W (l - l_before),   W = weight displacement J A^-1 J^T
// W is dense and takes as many solves with A as there are rows, all at once (condition_forces.h). Then g and J are updated at the new
// x, and this is repeated until x = x_free + displacement A^-1 J(x)^T p and g holds: forces have the directions of the end of the
// step. If iterates oscillate, they are mixed (mixing.h).
//
// If a rule sets `once`, the first round is the last: forces have the directions of the unconstrained motion, as in SOFA, and the
// conditions hold as far as they are linear.
//
// Nodes of an UncoupledConstraintCorrection respond with their own compliance instead of A^-1, without Newton's method. In a single
// round ConstraintSweeps may find the forces, up to its tolerance.
//
// A rule that weights forces at the start of the step by s (the trapezoidal rule: 1/2) has J = (1 - s) J(x) + s J(x0)
// in J^T p, with one l for the step: a given force acts with its whole weight. If a point has passed a corner, J(x0) and J(x)
// differ, and v would keep a component normal to the new segment, alternating for ever, which the next corner turns into energy.
// Therefore v is replaced by
//   v - A^-1 J^T (J(x) A^-1 J^T)^-1 s
// with s = J(x) v for the point on its wire. For other equalities s is half of the change of J v in the step, because bodies tied to
// the point take their part of the impulse. `push` rows have s = 0 and may release. This keeps the speed of a point on fixed wires,
// free or with others tied to it. If directions rotate by more than 120 degrees J is J(x), and a part is lost.
//
// Newton's method needs more than one such correction, because A belongs to one iterate (implicit_conditions.cpp). It
// carries the impulses J^T p found so far as a load, and each correction starts from there. Forces then keep the directions
// of the iterate of A until the next one: their rotation lags, as does the rotation of stresses in most matrices A;
// in a body compressed by a cable the two compensate each other. If a row gives the change of its gradient
// (LagrangianRows::Bend), this is a part of the matrix instead, always for `push` rows and for others if it is not small:
// A + B S B^T with the forces of the previous iterate,
//   (A + B S B^T)^-1 v = z - Y (S^-1 + B^T Y)^-1 B^T z,   z = A^-1 v,   Y = A^-1 B
// Cells that roll on a sphere rotate too far for a step without this term.
#pragma once
#include <array>
#include <map>
#include <string>
#include <vector>

#include "components/integrators/body_rows.h"
#include "components/integrators/constraint_sweeps.h"
#include "components/integrators/multiplier_parts.h"
#include "components/integrators/redundant_forces.h"
#include "framework/algebra/mixing.h"
#include "framework/mechanics/condition_forces.h"
#include "framework/simulation/system.h"

namespace stroma {

class Archive;
class UncoupledConstraintCorrection;

class Multipliers {
 public:
  /// The effect of impulses in a step.
  struct Rule {
    double displacement = 0;  ///< dx/du [s]
    double weight = 0;        ///< p = weight l [s]
    double old_share = 0;     ///< fraction of p along the gradients at the start of the step
    bool has_velocities = true;  ///< u is the system's v; otherwise, in statics, u is the displacement
    bool once = false;           ///< one round; not with Newton's method
  };

  /// Statistics of the last search for forces, as outputs of the integrator.
  void declare(DataTable& table);
  void compile(System& system);
  bool empty() const { return !system_ || system_->actors().lagrangian_constraints.empty(); }
  /// Starts a step. `carries`: the unconstrained x is computed with the load of addCarried().
  void begin(const Rule& rule, bool carries);
  /// Prepares a step that is divided: conditions violated at the present x, its start, are then reduced part by part.
  /// Returns false if all hold there.
  bool keepInitialViolation();
  /// Until the next call conditions are g(x) - (1 - share) g(x0), with x0 of keepInitialViolation(); for `push` only those violated
  /// there. 1: g(x).
  void setShare(double share) { violation_share_ = share; }
  /// With Newton's method: makes forces act along the gradients at the present x.
  void updateDirections();
  /// Moves x and v of the system until the conditions hold, and updates `change`, the change of u in the step.
  /// A report that did not converge has the remaining violation.
  /// `direction`: with Newton's method the change of u since updateDirections(); otherwise empty.
  void correct(LinearSolver& solver, SystemMatrix& matrix, Rows change, ConstRows direction, StopToken stop, StepReport& report);
  /// Corrects the velocities at the end of a step in which forces have changed conditions, as of a point that has passed a corner, if the
  /// rule weights forces at the start. False: unchanged.
  bool turnVelocities(LinearSolver& solver, SystemMatrix& matrix, StopToken stop, StepReport& report);
  /// The smallest tolerance of all conditions, or with `kept` the smallest violation that ends the run [m]; 0 if one has none.
  double leastTolerance(bool kept);
  /// out += J^T p of the previous step, or of the last carry() [N s].
  void addCarried(Rows out) const;
  /// The last correct() has left conditions to the next one, with updated directions.
  bool wasLeft() const { return is_left_; }
  ConstRows carried() const { return carried_.now(); }
  /// Restores an earlier carried().
  void restoreCarried(ConstRows carried) { carried_.set(carried); }
  /// Carries J^T p of the last correct() from now on; out += the change.
  void carry(Rows out);
  /// Keeps only this fraction of the last carry(); out += the change.
  void carryShare(double share, Rows out) { carried_.changeShare(share, out); }
  /// Mixes the iterate `to`, computed from `from`, and its load with earlier ones.
  void carryMixed(Mixing& mixing, ConstRows from, Rows to, Rows out) { carried_.mix(mixing, from, to, out); }

  /// With `carries`: nothing is carried, and all conditions hold at x without a force, as contact does if nothing is near.
  bool areFree();
  /// The step ends at the x of the last areFree(): all forces are zero.
  void clearForces();

  // ---- forwarded by the integrator ----
  ConstRows lastForces() const { return carried_.last(); }  ///< J^T l of the previous step [N]
  void setLastForces(ConstRows forces) { copy(forces, carried_.last()); }
  std::string doubt() const;
  void stepTaken();
  void reset();
  void serialize(Archive& archive);

 private:
  void findConditions();
  void subtractInitialViolation();
  double signAgainstPreviousRow(std::size_t row) const;
  bool isIdle(std::size_t row) const;
  /// With redundant rows W must be symmetric: its conditions are then taken along the directions of forces too.
  bool keepsDirections() const { return (carries_ || keeps_) && !yields_.empty(); }
  /// W is computed from J^T of the rows and their responses: the same, and cheap for rows on few bodies.
  bool couplesByDirections() const { return !yields_.empty() && (carries_ || keeps_ || rule_.old_share == 0); }
  bool isOnce() const { return rule_.once && !carries_; }
  bool changeConditions();
  bool changeDirections(bool releases);
  /// A row that turnVelocities() corrects, and the speed that it removes.
  struct Held {
    std::size_t row;
    bool pushes;
    double speed;
  };
  std::vector<Held> findHeld(ConstRows moves) const;
  double along(std::size_t row, ConstRows moves) const;
  bool respondToTurn(const std::vector<Held>& held, LinearSolver& solver, SystemMatrix& matrix, StopToken stop, StepReport& report);
  Eigen::VectorXd findTurn(const Eigen::MatrixXd& w, const std::vector<Held>& held, StopToken stop, StepReport& report) const;
  bool prepareRound(bool is_first, LinearSolver& solver, SystemMatrix& matrix, StopToken stop, StepReport& report);
  bool areFewAndSmooth() const;
  void pullBack(std::size_t row, Rows out) { pullBack(rows_.entriesOf(rows_.rows()[row]), out); }
  void takeDirections();
  void takeDirection(std::size_t row);
  bool hasDirection(std::size_t row) const { return row < has_direction_.size() && has_direction_[row]; }
  void computeNewDirections();
  bool mayLeaveDirections();
  bool keepDirections(int round);
  bool conditionsHold(int round, double& step);
  void takeBends();
  double shareOf(const LagrangianRows::Bend& bend) const;
  bool respondToBends(LinearSolver& solver, SystemMatrix& matrix, StopToken stop, StepReport& report);
  bool solveForCarried(LinearSolver& solver, SystemMatrix& matrix, ConstRows direction, StopToken stop, StepReport& report);
  void pullBack(std::span<const LagrangianRows::Entry> entries, Rows out);
  bool respond(LinearSolver& solver, SystemMatrix& matrix, StopToken stop, StepReport& report);
  void couple();
  void findLive();
  bool takeBodyRows(bool is_first, LinearSolver& solver, SystemMatrix& matrix, StopToken stop, StepReport& report);
  bool solveForBodies(LinearSolver& solver, SystemMatrix& matrix, StopToken stop, StepReport& report);
  bool makesMotionAlone() const { return is_of_bodies_ && is_without_w_; }
  RedundantForces::Problem problemWith(const BodyRows* bodies, double budget) const;
  ConditionForces::Violation worst() {
    return makesMotionAlone() ? redundant_.worst(rows_.rows(), live_, solve_.sizes, allowed_) : solve_.worst(rows_.rows(), allowed_);
  }
  void guessForces();
  void findForces(StopToken stop);
  bool answer(LinearSolver& solver, SystemMatrix& matrix, Vector& response, StopToken stop, StepReport& report);
  void request(ConstRows right_side, Vector& response);
  bool solveRequested(LinearSolver& solver, SystemMatrix& matrix, StopToken stop, StepReport& report);
  SolveReport solveInTurn(LinearSolver& solver, SystemMatrix& matrix, StopToken stop);
  void forgetChanged();
  void leaveOutForces();
  void sumResponses();
  void apply(Rows change);
  void give();
  long iterationsOfAll() const { return solve_.steps + solve_.rounds + redundant_.steps + redundant_.rounds; }
  std::vector<UncoupledConstraintCorrection*> findUncoupled() const;
  ConstraintSweeps* findSweeps() const;
  bool holdsPoint(std::size_t row) const;
  const State* stateOf(Index row) const;
  bool isOfFrame(Index row) const;
  bool isTurn(Index row) const;
  bool findBlocks(std::size_t& other);
  void takeSwept();
  void keepContactForces();
  bool sweepForces(StopToken stop);
  static constexpr double held_within = 1e-9;  ///< of the place: by which conditions may be off
  bool isNoise(double step);
  bool isSpent(StepReport& report);
  std::string nameOf(std::size_t row) const;
  std::string nodesOf(std::size_t row) const;
  void judge(double step, double size, double rounding, StepReport& report);

  System* system_ = nullptr;
  Rule rule_;
  bool carries_ = false, keeps_ = false;  ///< keeps_: uses directions of earlier rounds
  int kept_since_ = 0;                    ///< the round in which keeps_ last changed
  std::vector<char> keeps_directions_;    ///< per constraint: it keeps its own
  LagrangianRows rows_, old_rows_;
  std::vector<std::size_t> ends_;          ///< of the rows of each constraint
  ConditionForces solve_;                  ///< W, g and l
  RedundantForces redundant_;              ///< the initial guess of its search, for rows with a compliance
  std::vector<double> yields_;             ///< compliance per row; empty: none has one
  std::vector<Vector> directions_;         ///< J^T of each row, shape (independent rows)
  std::vector<char> has_direction_;             ///< per row: it has a direction
  std::vector<std::size_t> new_rows_;      ///< rows without one; work space
  Vector directions_at_, here_;                 ///< x at which directions were computed; work space
  std::vector<double> like_;               ///< 1 or -1: the direction equals that of the previous row, or its opposite
  std::vector<Vector> responses_;          ///< A^-1 times the directions
  std::vector<char> is_answered_;          ///< per row: the response is known or requested
  std::vector<std::size_t> new_answers_;   ///< rows whose response is new in this round; work space, like the next
  std::vector<ConstRows> requested_;           ///< right-hand sides
  std::vector<Rows> solutions_;
  std::vector<std::size_t> live_, coupled_;  ///< rows of W, and of the previous W
  bool has_new_answers_ = false;             ///< since the previous W
  DirectionOverlaps overlaps_;
  BodyRows bodies_;
  std::array<Vector, BodyRows::loads> body_loads_, body_answers_;
  bool asked_bodies_ = false;   ///< in this step
  bool knows_bodies_ = false;   ///< bodies_ has the matrix of the step
  bool is_of_bodies_ = false;   ///< all rows of the round act on bodies_, which replace directions and responses
  bool is_without_w_ = false;   ///< W was not computed for them
  std::vector<double> own_;                ///< per row: its diagonal entry of W
  std::vector<double> allowed_, kept_allowed_;  ///< tolerance per row, and the violation that ends the run; work space
  std::vector<Vector> start_directions_;   ///< J(x0)^T of each row, with an old share
  std::vector<double> start_speeds_;       ///< J(x0) v0 of each row, with an old share and velocities
  GradientBends bends_;
  long made_before_ = 0, searches_before_ = 0;  ///< iterations and number of the searches of all previous steps
  int iterations_ = 0;    ///< of the last step
  double residual_ = 0;   ///< at their end
  bool knows_forces_ = false;  ///< of the rows of this step
  std::vector<UncoupledConstraintCorrection*> uncoupled_;  ///< bodies whose nodes respond one by one
  Vector pushes_;                                          ///< right_side_ with the part of these bodies
  ConstraintSweeps* sweeps_ = nullptr;
  std::vector<ConstraintSweeps::Block> blocks_;
  std::map<std::array<int, 2>, std::array<double, 3>> contact_forces_;  ///< of the last step, by names [N]
  std::vector<std::size_t> swept_ends_;  ///< ends_ of the step that swept_ belongs to
  Eigen::VectorXd swept_, sweeping_;  ///< forces [N] of the last step, the initial guess of sweeps, and of the present one
  bool is_swept_ = false;             ///< forces of the present step are from sweeps
  std::string not_swept_;             ///< a constraint that prevents sweeps
  Vector start_, work_, right_side_;
  Vector free_;            ///< x with no constraint forces except the carried ones
  Vector whole_, before_;  ///< the change of u by constraint forces, now and a round ago
  CarriedForces carried_;
  Vector base_;            ///< A^-1 times the carried load
  Eigen::VectorXd last_forces_;  ///< of the previous round
  bool is_left_ = false;
  bool has_changed_ = false;  ///< conditions have changed in the step
  std::vector<LagrangianConstraint*> asked_to_change_;  ///< work space
  static constexpr int most_changes = 100;  ///< of conditions by their forces, each with its own rounds
  int changes_left_ = most_changes;         ///< 0: they have not come to an end
  double budget_ = 100;     ///< limit of spent_ [1e9]
  double spent_ = 0;        ///< on searches in the step: sum of rows^3 of the eliminations
  bool is_spent_ = false;
  int times_left_ = 0;  ///< number of times in the step that directions rotated far
  double share_ = 1;
  std::vector<double> way_;  ///< g(x0) of keepInitialViolation(), per row
  double violation_share_ = 1;
  Mixing mixing_;
};

}  // namespace stroma
