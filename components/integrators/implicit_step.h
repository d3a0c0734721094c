// SPDX-License-Identifier: LGPL-2.1-or-later
// One implicit step, linearised once or solved by Newton's method, shared by all implicit integrators. They differ only in
// the few numbers of a scheme.
#pragma once
#include <string>

#include "components/integrators/conditions_newton.h"
#include "components/integrators/energy_watch.h"
#include "components/integrators/exact_tangent.h"
#include "components/integrators/light_bodies.h"
#include "components/integrators/newton_solver.h"
#include "components/integrators/orientations.h"
#include "components/integrators/turning_bodies.h"
#include "components/integrators/whole_matrix.h"
#include "framework/mechanics/right_side.h"
#include "framework/mechanics/turns_stresses.h"
#include "framework/simulation/integrator.h"
#include "framework/simulation/step_limits.h"
#include "framework/simulation/system.h"

namespace stroma {

/// With F(x, v) = f(x, v) + rK K(x) v - rM M v the whole force and u the unknown velocity, a step solves
///   M (u - v0 - velocity_predictor) = weight F(x(u), u) + old_weight F(x0, v0),
///   x(u) = x0 + drift v0 + position_predictor + displacement (u - v0)
struct ImplicitScheme {
  double weight = 0, old_weight = 0;  ///< [s]
  double drift = 0;                   ///< [s]
  double displacement = 0;            ///< dx/du [s]
  double time = 0, old_time = 0;      ///< of F(x(u), u) and of F(x0, v0), for time-dependent forces [s]
  double moved_after = 0;             ///< x also moves by this times (u - v0) when u has been found [s]
  bool has_history = false;           ///< ImplicitStep::position_predictor and velocity_predictor are not zero
  bool from_predictor = false;        ///< one linear solve, for u - v0 - velocity_predictor
};

class ImplicitStep final : public NonlinearProblem {
 public:
  // ---- set by an integrator from its attributes, before compile() ----
  double rayleigh_mass = 0;        ///< rM [1/s], added to the factor of each mass
  double rayleigh_stiffness = 0;   ///< rK [s], added to the factor of each force field
  bool own_in_matrix = false;      ///< Rayleigh factors of force fields and masses are only in the tangent, not in the force
  bool allows_massless = false;    ///< allows nodes without mass: rows with stiffness only
  NewtonSettings newton_settings;  ///< replaced by a NewtonSolver of the scene
  bool second_order = false;       ///< the order of the rule if its equations are solved accurately
  bool only_linear = false;        ///< the rule has no equations for Newton's method
  Vector position_predictor,
      velocity_predictor;  ///< [m], [m/s], shape (independentRows()); used with has_history; fixed directions are ignored

  /// The momentum predictor of each of bodies(), used for them instead of M velocity_predictor [kg m^2/s]; with
  /// has_history.
  std::vector<Vec3> momentum_predictor;
  const TurningBodies& bodies() const { return bodies_; }
  /// Obstacles may limit steps.
  bool isLimited() const { return !limits_.empty(); }
  bool hasConditions() const { return !multipliers_.empty(); }  ///< of Lagrangian constraints
  /// J w of bodies() before and after the last solve().
  const std::vector<Vec3>& startMomenta() const { return start_momenta_; }
  const std::vector<Vec3>& endMomenta() const { return end_momenta_; }

  bool one_round = false;  ///< constraint forces use the directions of the unconstrained motion, as in SOFA

  /// Uses Newton's method if a force field limits steps, otherwise as many linear solves as the order of the rule requires: for a
  /// second-order rule two if a stiffness is an approximate derivative, three if forces rotate rigid bodies, else one.
  static constexpr int needed_solves = 0;
  static constexpr int enough_with_limits = 30;  ///< Newton iterations
  ImplicitStep() { newton_settings.iterations = needed_solves; }
  void declareDamping(DataTable& table);       ///< rayleighMass, rayleighStiffness
  void declareNewton(DataTable& table);        ///< newtonIterations, newtonTolerance, newtonForcing
  void declareNewtonSolver(DataTable& table);  ///< newtonSolver, residualGraph
  void declareConditions(DataTable& table) { multipliers_.declare(table); }

  /// Allocates; throws ComponentError if a linear solver or a mass is missing.
  void compile(Integrator& integrator, System& system);
  /// Moves System::x and v from x0, v0, after beginStep(), to x(u), u. If it fails they are not usable.
  StepReport solve(const ImplicitScheme& scheme, StopToken stop);
  /// u - v0 of the last solve() [m/s].
  ConstRows change() const { return change_; }
  /// out = F(x, v) at the system's x and v [N], not projected; shape (independentRows()). `starts`: the force is also used in the
  /// equations of the step, weighted with that at the end, whose part of the impulse is `of_end`.
  void wholeForce(double time, Rows out, bool starts, double of_end);
  LinearSolver& linearSolver() const { return *solver_; }
  SystemMatrix& whole(SystemMatrix& matrix) { return whole_.of(matrix); }  ///< the matrix with all of its stiffness
  // ---- constraint forces for a rule that makes its own linear solve, as in solve() ----
  void beginConditions(double displacement, double weight) { multipliers_.begin({displacement, weight, 0, true, one_round}, false); }
  /// Adds the effect of these forces to x, v and `change`, the change of v in the solve with `matrix`.
  void meetConditions(SystemMatrix& matrix, Rows change, StopToken stop, StepReport& report) {
    if (!multipliers_.empty()) multipliers_.correct(*solver_, matrix, change, {}, stop, report);
  }
  /// Projections by constraints whose nodes are free in the matrix.
  void projectFree(double t, double t_end, Rows b) const {
    for (const auto& [constraint, side] : right_sides_)
      if (constraint->activeIn(t, t_end)) side->projectRightSide(b);
  }
  bool solvesOnce() const { return newton_.settings.iterations == 1; }
  /// The scene or its contact asks for Newton's method.
  bool iterates() const { return !solvesOnce() && !newton_.settings.fixed_count; }
  std::string describe() const;
  // ---- forwarded by the integrator ----
  void stepTaken() { exact_.stepTaken(), multipliers_.stepTaken(), energy_.stepTaken(); }
  void sceneChanged() { energy_.forget(); }
  std::string doubt(const std::string& path) const;  ///< artificial energy, or a body that lags behind
  void reset() {
    exact_.reset(), multipliers_.reset(), energy_.forget();
    exact_tangent_steps_ = 0;
  }
  void serialize(Archive& archive) {
    exact_.serialize(archive), multipliers_.serialize(archive), energy_.serialize(archive);
    measure_.serialize(archive, "force_length");
  }

  // ---- the equations for Newton's method ----
  void residual(Rows out) override;
  SystemMatrix& tangent() override;
  void projectToFree(Rows d) const override { stroma::projectToFree(*system_, d); }
  bool useDefiniteTangent(bool definite) override;
  bool mayHaveUnstableDirections() const override { return turns_ && tangents_ > 0 && !turning_.empty(); }
  void excludeUnstableDirections() override;
  bool useDefiniteDamping() override;
  double energy() override;
  Rows unknowns() override { return v(); }
  bool guess(Rows d) override;
  Rows changeSinceStart() override {
    takeChange();
    return change_;
  }
  void unknownsChanged() override { place({0, x().count}); }
  void addTo(Rows u, double s, ConstRows d) const override { addTo(u, s, d, {0, d.count}); }
  double residualOfParts(ConstRows residual) const override;
  LightBodies* lightBodies() override { return &light_; }
  double weightOfForces() const override { return scheme_.weight; }
  double longestStep(ConstRows d) override;
  bool mayMeetBarriers() const override { return !limits_.empty(); }
  bool mayMeetPenalties() const override { return meets_walls_; }
  bool updatesLagged() override;
  bool hasRemainingMotion() override { return carries() || limits_.hasRemainingMotion(); }
  bool addPush(Rows residual) override;
  bool advanceRemainingMotion(Rows d, bool wholly) override;
  bool isIntermediate() override { return lack_ > 0 || limits_.isIntermediate(); }
  double displacementPerUnknown() const override { return scheme_.displacement; }
  ConstRows positions() const override { return x(); }
  const Motion* motionOfFrames() const override { return system_->motion().turns() ? &system_->motion() : nullptr; }
  void updateNorms() override {
    if (system_->motion().turns()) measure_.take(tangent());
  }
  double sizeOf(ConstRows residual) const override { return measure_.force(residual); }
  double lengthOf(ConstRows d) const override { return measure_.way(d); }
  double travelled() const override;
  double loadScale() const override;
  double loads() override { return scheme_.weight * loadsOn(*system_, measure_, right_side_); }
  RoundOff roundOff() override;

 private:
  struct RowRange {
    Index first = 0, end = 0;
    Rows of(Rows all) const { return all.segment(first, end - first); }
    ConstRows of(ConstRows all) const { return all.segment(first, end - first); }
  };
  void place(RowRange rows);  ///< see unknownsChanged()
  void findDamped();
  bool endDefiniteDamping();
  void addTo(Rows u, double s, ConstRows d, RowRange rows) const;
  RowRange rowsMovedBy(ConstRows d) const;
  Rows x() const { return system_->independent(system_->x); }
  Rows v() const { return system_->independent(system_->v); }
  void chooseSolves(bool keeps_energy);  ///< keeps_energy: the rule has no damping
  std::string doubtOfOneSolve(const std::string& path) const;
  void setTime(double time);
  StepReport solveLinearised(StopToken stop);
  StepReport solveAsNeeded(StopToken stop);
  StepReport solveIterating(StopToken stop);
  StepReport solveFromHere(StopToken stop);
  bool mayTryExact() const;
  bool beginFaster();
  StepReport solveConditions(StopToken stop);
  bool hasForces() const { return !multipliers_.empty() && !is_free_; }  ///< constraint forces take part in the solve
  // implicit_parts.cpp
  bool mayDivide(const StepReport& report) const;
  bool findWayOfHeld();
  bool carryOn(double more, StopToken stop, StepReport& report);
  StepReport solveInParts(const StepReport& whole, StopToken stop);
  StepReport startAgain(const StepReport& before);
  void takeBack(StepReport& report);
  void takeChange();
  void turnVelocities(StopToken stop, StepReport& report);
  void startIterating();
  MatrixFactors tangentFactors() const;
  /// In each solve of a step prescribed motion advances as far as possible.
  bool carries() const { return lack_ > 0 && carries_ < 500; }
  void addDamping(double factor, Rows out);
  void addMassDamping(double factor, Rows out);
  void chooseTurning();
  void addTurning(bool on);
  void keepTurning(bool on);
  void addMassWhereTheStepStarts(Rows out) const;
  void advance();
  void startBodies();
  Vec3 predictedTurn(std::size_t body, const Vec3& w0) const;
  Vec3 turnedMomentum(std::size_t body) const;
  void turnBodies();

  System* system_ = nullptr;
  LinearSolver* solver_ = nullptr;
  NewtonSolver* settings_component_ = nullptr;
  Newton newton_;
  std::string approximation_;  ///< why one solve is not enough
  bool keeps_order_ = false;   ///< the rule keeps its order with one solve
  int enough_solves_ = 2;      ///< otherwise
  std::string limiter_;        ///< the force field for which Newton's method was chosen; empty: the scene asks for it, or nobody
  StepLimits limits_;
  WholeIfNeeded whole_;
  ForceMeasure measure_;
  LightBodies light_;
  Multipliers multipliers_;
  Multipliers::Rule rule_;  ///< of the step
  ConditionsNewton conditions_;  ///< with Newton's method and constraint forces
  ExactTangent exact_;
  EnergyWatch energy_;
  std::vector<std::pair<TurnsStresses*, const ForceField*>> turning_;  ///< see chooseTurning()
  std::vector<ForceField*> damped_;    ///< damped fields with a definite stiffness, see findDamped()
  bool has_definite_damping_ = false;  ///< they use it for the rest of the step
  bool turns_ = false;  ///< tangents of the step include it, except the first
  int tangents_ = 0;    ///< of the step so far
  int exact_tangent_steps_ = 0;
  ImplicitScheme scheme_;
  bool has_rayleigh_mass_ = false, has_rayleigh_stiffness_ = false, has_own_stiffness_damping_ = false;
  bool depends_on_time_ = false;
  bool meets_walls_ = false;  ///< some fields are lagged: mostly penalties that start on first contact
  bool lends_energy_ = false;  ///< some forces have a potential only within a solve
  bool has_constant_ = false;  ///< with Newton's method: constant_ is not zero

  Vector right_side_;      ///< shape (allRows())
  Vector change_;          ///< u - v0
  Vector constant_;        ///< old_weight F(x0, v0), plus present constraint forces with Newton's method
  Vector x0_, v0_, work_;  ///< the state before the step, for Newton's method
  Vector carried_;         ///< prescribed displacement [m], shape (independentRows()); only with step limits, or in parts
  Vector good_;            ///< u at the end of the last part of a step; see implicit_parts.cpp
  double lack_ = 0;        ///< the remaining fraction of the step
  int carries_ = 0;
  bool is_free_ = false;      ///< the step ignores Lagrangian constraints
  bool is_to_guess_ = false;  ///< no solve of the step has begun
  Orientations orientations_;
  TurningBodies bodies_;
  std::vector<Vec3> start_momenta_, end_momenta_;
  mutable std::vector<Vec3> velocities_;  ///< work space of addTo()

  std::vector<std::pair<const ProjectiveConstraint*, const ProjectsRightSide*>> right_sides_;
  std::vector<double> graph_;
  Link<NewtonSolver> newton_link_{"Newton solver"};
};

}  // namespace stroma
