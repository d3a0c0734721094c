// SPDX-License-Identifier: LGPL-2.1-or-later
// Forces of Lagrangian constraints in an implicit step. The step without them has found u, with its matrix A of A du = b.
// Impulses p = weight l along the gradients J then change
//   u by c = A^-1 J^T p,   x by displacement c,   conditions g(x) by W (l - l_before),   W = weight displacement J A^-1 J^T
// W is dense, of as many solves with A as there are rows, all at once (condition_forces.h). Then g and J are computed anew where x has come
// to, and it is repeated until x = x_free + displacement A^-1 J(x)^T p and g holds: forces have the directions of the end of the
// step. Where that swings, iterates are mixed (mixing.h).
//
// Where a rule says once, the first round is the last: forces have the directions of the motion without them, as SOFA's, and the
// conditions hold as far as they are linear.
//
// Nodes of an UncoupledConstraintCorrection answer with their own compliance in the place of A^-1, without Newton's method. In one
// round ConstraintSweeps may find the forces, up to its tolerance.
//
// A rule that weighs forces where the step starts with the share s (the trapezoidal one: 1/2) has J = (1 - s) J(x) + s J(x0)
// in J^T p, with one l for the step: a force that is given acts with its whole weight. Where a point has passed a corner, J(x0) and J(x)
// differ, and v would keep a part across the new piece, to and fro for ever, of which the next corner makes energy. Then v becomes
//   v - A^-1 J^T (J(x) A^-1 J^T)^-1 s
// s = J(x) v of the point on its wire. Of others that hold s is half of what J v has changed by in the step, because what is tied to
// the point takes its part of the impulse. What pushes has s = 0 and may let go. This keeps the speed of a point on wires that stand,
// free or with others tied to it. Where directions turn by more than 120 degrees J is J(x), and a part is lost.
//
// Newton's method needs more than one such correction, because A is the matrix of one place (implicit_conditions.cpp). It
// carries the impulses J^T p found so far as a load, and each correction starts from there. Forces then keep the directions
// of the iterate that A is of, until the next: what they turn by is taken late, as is what stresses turn by in most matrices A;
// of a body that a cable presses together the one balances the other. How gradients turn where a row says so
// (LagrangianRows::Bend) is a part of the matrix instead, of pushes always and of others where it is no small one,
// A + B S B^T with the forces of the iterate before:
//   (A + B S B^T)^-1 v = z - Y (S^-1 + B^T Y)^-1 B^T z,   z = A^-1 v,   Y = A^-1 B
// Cells that roll on a sphere turn by more than any step that lacks it can follow.
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
  /// What a step makes of impulses.
  struct Rule {
    double displacement = 0;  ///< dx/du [s]
    double weight = 0;        ///< p = weight l [s]
    double old_share = 0;     ///< of p along the gradients where the step starts
    bool has_velocities = true;  ///< u is the system's v; else of statics, and u is the change itself
    bool once = false;           ///< one round; not with Newton's method
  };

  /// What the last step took to find forces, as outputs of the integrator.
  void declare(DataTable& table);
  void compile(System& system);
  bool empty() const { return !system_ || system_->actors().lagrangian_constraints.empty(); }
  /// Where the step starts. `carries`: x without forces of constraint has been found under those of addCarried().
  void begin(const Rule& rule, bool carries);
  /// Of a step that is made in parts: conditions that do not hold at the present x, where the step starts, are to hold by a share of it.
  /// False where all hold there.
  bool keepWay();
  /// Until the next call conditions are g(x) - (1 - share) g(x0), x0 of keepWay(); of pushes only those that did not hold. 1: all of it.
  void setShare(double share) { share_of_way_ = share; }
  /// With Newton's method: forces act along the gradients at the present x from now on.
  void aim();
  /// Moves x and v of the system until the conditions hold; `change`: what u has changed by in the step, follows.
  /// A report that did not converge says by how much they do not.
  /// `direction`: of Newton's method, what u has come by from where aim() was; else of no rows.
  void correct(LinearSolver& solver, SystemMatrix& matrix, Rows change, ConstRows direction, StopToken stop, StepReport& report);
  /// The velocities of a step that has ended, where conditions have changed by their forces and the rule weighs those where it starts,
  /// as of a point that has passed a corner. False: they stay.
  bool turnVelocities(LinearSolver& solver, SystemMatrix& matrix, StopToken stop, StepReport& report);
  /// By how much every condition may be off and hold, or be kept and told [m]; 0 where one may not.
  double leastTolerance(bool kept);
  /// out += J^T p, of the step before and then of the last carry() [N s].
  void addCarried(Rows out) const;
  /// The last correct() has left conditions to the next one, with other directions.
  bool wasLeft() const { return is_left_; }
  ConstRows carried() const { return carried_.now(); }
  /// What carried() was before.
  void carryAgain(ConstRows carried) { carried_.set(carried); }
  /// From now on J^T p of the last correct() is carried; out += by how much that is another.
  void carry(Rows out);
  /// Only this share of what the last carry() added; out += by how much that is another.
  void carryShare(double share, Rows out) { carried_.changeShare(share, out); }
  /// The iterate `to` that came of `from` is mixed with those before, and what is carried with it.
  void carryMixed(Mixing& mixing, ConstRows from, Rows to, Rows out) { carried_.mix(mixing, from, to, out); }

  /// Of one that carries: nothing is, and all conditions hold where x is, without a force. Contact where nothing is near has such.
  bool areFree();
  /// The step ends where areFree() was asked last.
  void giveNone();

  // ---- what an integrator that carries passes on ----
  ConstRows lastForces() const { return carried_.last(); }  ///< J^T l of the step before [N]
  void setLastForces(ConstRows forces) { copy(forces, carried_.last()); }
  std::string doubt() const;
  void stepTaken();
  void reset();
  void serialize(Archive& archive);

 private:
  void findConditions();
  void leaveOutWay();
  double likeRowBefore(std::size_t row) const;
  bool isIdle(std::size_t row) const;
  /// Where rows say the same W has to be symmetric: its conditions are those along the directions of forces, too.
  bool keepsDirections() const { return (carries_ || keeps_) && !yields_.empty(); }
  /// W is J^T of rows with their responses: the same, and cheap for rows of few bodies.
  bool couplesByDirections() const { return !yields_.empty() && (carries_ || keeps_ || rule_.old_share == 0); }
  bool isOnce() const { return rule_.once && !carries_; }
  bool changeConditions();
  bool changeDirections(bool releases);
  /// A row that turnVelocities() looks at, and the speed that it takes.
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
  bool isAimed(std::size_t row) const { return row < is_aimed_.size() && is_aimed_[row]; }
  void aimAtNew();
  bool leavesDirections();
  bool keepDirections(int round);
  bool conditionsHold(int round, double& step);
  void takeBends();
  double shareOf(const LagrangianRows::Bend& bend) const;
  bool respondToBends(LinearSolver& solver, SystemMatrix& matrix, StopToken stop, StepReport& report);
  bool answerCarried(LinearSolver& solver, SystemMatrix& matrix, ConstRows direction, StopToken stop, StepReport& report);
  void pullBack(std::span<const LagrangianRows::Entry> entries, Rows out);
  bool respond(LinearSolver& solver, SystemMatrix& matrix, StopToken stop, StepReport& report);
  void couple();
  void findLive();
  bool takeBodyRows(bool is_first, LinearSolver& solver, SystemMatrix& matrix, StopToken stop, StepReport& report);
  bool answerBodies(LinearSolver& solver, SystemMatrix& matrix, StopToken stop, StepReport& report);
  bool makesMotionAlone() const { return is_of_bodies_ && is_without_w_; }
  RedundantForces::Problem problemWith(const BodyRows* bodies, double budget) const;
  ConditionForces::Violation worst() {
    return makesMotionAlone() ? redundant_.worst(rows_.rows(), live_, solve_.sizes, allowed_) : solve_.worst(rows_.rows(), allowed_);
  }
  void expectForces();
  void findForces(StopToken stop);
  bool answer(LinearSolver& solver, SystemMatrix& matrix, Vector& response, StopToken stop, StepReport& report);
  void ask(ConstRows right_side, Vector& response);
  bool answerAsked(LinearSolver& solver, SystemMatrix& matrix, StopToken stop, StepReport& report);
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
  bool carries_ = false, keeps_ = false;  ///< keeps_: directions of rounds before
  int kept_since_ = 0;                    ///< the round since when, or since when not
  std::vector<char> keeps_directions_;    ///< of each constraint: it does
  LagrangianRows rows_, old_rows_;
  std::vector<std::size_t> ends_;          ///< of the rows of each constraint
  ConditionForces solve_;                  ///< W, g and l
  RedundantForces redundant_;              ///< where its search begins, of rows that yield
  std::vector<double> yields_;             ///< of each row; empty: none does
  std::vector<Vector> directions_;         ///< J^T of each row, shape (independent rows)
  std::vector<char> is_aimed_;             ///< of each row: it has a direction
  std::vector<std::size_t> new_rows_;      ///< that have none; work space
  Vector aimed_at_, here_;                 ///< x where directions were taken; work space
  std::vector<double> like_;               ///< 1 or -1: that of the row before, or its opposite
  std::vector<Vector> responses_;          ///< A^-1 of them
  std::vector<char> is_answered_;          ///< of each row: they are known, or asked for
  std::vector<std::size_t> new_answers_;   ///< rows of the round that were not; work space, as is
  std::vector<ConstRows> asked_;           ///< right sides
  std::vector<Rows> answers_;
  std::vector<std::size_t> live_, coupled_;  ///< rows of W, and of the one before
  bool has_new_answers_ = false;             ///< since that
  DirectionOverlaps overlaps_;
  BodyRows bodies_;
  std::array<Vector, BodyRows::loads> body_loads_, body_answers_;
  bool knows_bodies_ = false;   ///< bodies_ has the matrix of the step
  bool is_of_bodies_ = false;   ///< the rows of the round are of bodies_, which stand for directions and responses
  bool is_without_w_ = false;   ///< W has not been made for them
  std::vector<double> own_;                ///< of each row: its diagonal of W
  std::vector<double> allowed_, kept_allowed_;  ///< by how much each row may be off, and be kept; work space
  std::vector<Vector> start_directions_;   ///< J(x0)^T of each row, with an old share
  std::vector<double> start_speeds_;       ///< J(x0) v0 of each row, where that is so and there are velocities
  GradientBends bends_;
  long made_before_ = 0, searches_before_ = 0;  ///< iterations of the searches of all steps before, and how many these are
  int iterations_ = 0;    ///< of the last step
  double residual_ = 0;   ///< where they ended
  bool knows_forces_ = false;  ///< of the rows of this step
  std::vector<UncoupledConstraintCorrection*> uncoupled_;  ///< bodies whose nodes answer one by one
  Vector pushes_;                                          ///< right_side_ with what these take of it
  ConstraintSweeps* sweeps_ = nullptr;
  std::vector<ConstraintSweeps::Block> blocks_;
  std::map<std::array<int, 2>, std::array<double, 3>> contact_forces_;  ///< of the last step, by names [N]
  std::vector<std::size_t> swept_ends_;  ///< ends_ of the step that swept_ is of
  Eigen::VectorXd swept_, sweeping_;  ///< forces of the last step [N], where sweeps go on, and of the present one
  bool is_swept_ = false;             ///< so are forces of the present one
  std::string not_swept_;             ///< a constraint that has kept sweeps from being made
  Vector start_, work_, right_side_;
  Vector free_;            ///< x without forces of constraint but those carried
  Vector whole_, before_;  ///< what they change u by, now and a round ago
  CarriedForces carried_;
  Vector base_;            ///< A^-1 of what is carried
  Eigen::VectorXd last_forces_;  ///< of the round before
  bool is_left_ = false;
  bool has_changed_ = false;  ///< conditions have, in the step
  std::vector<LagrangianConstraint*> asked_to_change_;  ///< work space
  static constexpr int most_changes = 100;  ///< of conditions by their forces, each with rounds of its own
  int changes_left_ = most_changes;         ///< 0: they have not come to an end
  double budget_ = 100;     ///< of spent_ [a thousand rows' cube]
  double spent_ = 0;        ///< in the step on searches: the cube of the rows of each elimination
  bool is_spent_ = false;
  int times_left_ = 0;  ///< in the step, where directions turned far
  double share_ = 1;
  std::vector<double> way_;  ///< g(x0) of keepWay(), per row
  double share_of_way_ = 1;
  Mixing mixing_;
};

}  // namespace stroma
