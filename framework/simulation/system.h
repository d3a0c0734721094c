// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <optional>
#include <vector>

#include "framework/simulation/constraint_set.h"
#include "framework/simulation/input_forces.h"
#include "framework/simulation/mapping_chain.h"
#include "framework/simulation/mechanical_matrix.h"
#include "framework/simulation/phase_times.h"
#include "framework/simulation/position_corrections.h"

namespace stroma {

class Integrator;

/// The unknowns moved by one integrator, each kind in one contiguous vector, and the forces on them. Its parts:
/// constraints() define what may move, matrix() is the matrix of a linear solve, and system_report.h describes the
/// system in messages.
class System final {
 public:
  /// Throws ComponentError.
  explicit System(const SystemMembers& members);
  System(const System&) = delete;

  // ---- unknowns; shape (allRows()), independent states first ----
  Vector x, v, f;
  Index allRows() const { return actors_.all_rows; }
  Index independentRows() const { return actors_.independent_rows; }
  const std::vector<State*>& states() const { return actors_.states; }
  const std::vector<ForceField*>& forceFields() const { return actors_.force_fields; }
  const std::vector<Mass*>& masses() const { return actors_.masses; }
  const Actors& actors() const { return actors_; }
  /// Integrators use it to add increments to x.
  const Motion& motion() const { return actors_.motion; }
  /// The independent rows of a vector of this system.
  Rows independent(Rows all) const { return all.head(independentRows()); }
  ConstRows independent(ConstRows all) const { return all.head(independentRows()); }
  Rows independent(Vector& all) const { return all.head(independentRows()); }
  ConstRows independent(const Vector& all) const { return all.head(independentRows()); }
  Integrator& integrator() const { return integrator_; }
  LinearSolver* linearSolver() const;  ///< the integrator's partner, or null
  Node& node() const;                  ///< the integrator's
  /// Other integrators whose bodies move in this system.
  const std::vector<MergedIntegrator>& merged() const { return merged_; }
  /// Everything below its integrators, and whatever acts on their bodies from elsewhere.
  const std::vector<Component*>& components() const { return components_; }

  // ---- the sequence of a step: beginStep(), the integrator's step, endStep(), called by Simulation ----
  /// Sets forces to the end of the step, activates or ends constraints, and updates mapped states.
  void beginStep(const StepContext& context);
  /// Completes a step from positions `x_start`: sets prescribed motion and tied rows exactly, then applies position
  /// constraints and updates mapped states.
  void endStep(const StepContext& context, ConstRows x_start, StepReport& report);
  /// Called before a step that may be rejected, and after it was: stores and restores the memory of the linear solver.
  void keepSolver();
  void takeSolverBack();
  void applyMappings();  ///< including passive ones

  // ---- forces ----
  /// f = sum of forces at (x, v), including gravity; prepares the stiffness at x. Not projected.
  void computeForce(ConstRows x, ConstRows v, Rows f);
  /// The same, plus K p of all fields with their factors (MatrixFactors::of()), in one pass.
  /// After requestForce() System::f is the force alone; no other bit changes.
  void computeForceAndProduct(ConstRows x, ConstRows v, ConstRows p, const MatrixFactors& factors, Rows out);
  /// Called once by an integrator that reads System::f after computeForceAndProduct(); observers ask a State.
  void requestForce() { keeps_force_ = true; }
  /// At the end of a step, before histories advance: sets System::f to the force at (x, v) and time t if observers requested it.
  void computeRequestedForce(double t);
  /// Sets the time [s] of time-dependent forces; beginStep() sets the end of the step.
  void setTime(double t);
  /// out += K p of all fields with their factors (MatrixFactors::of()) and K of the last force; on independent rows.
  void addStiffnessProduct(ConstRows p, const MatrixFactors& factors, Rows out) const;
  void addMassProduct(ConstRows p, double factor, Rows out) const;
  /// out += sum of (rayleigh + rayleighMass of the mass) * factor * M p
  void addRayleighMassProduct(ConstRows p, double rayleigh, double factor, Rows out) const;
  /// Increases when K or C may have changed.
  long derivativesRevision() const { return derivatives_revision_; }

  // ---- energies [J] ----
  double kineticEnergy() const { return kineticEnergy(v); }
  double kineticEnergy(ConstRows v_then) const;
  double potentialEnergy(ConstRows x_now) const { return elasticEnergy(x_now) + gravityEnergy(x_now); }
  double elasticEnergy(ConstRows x) const;  ///< force fields only, loads included
  double gravityEnergy(ConstRows x) const;
  bool isConservative() const;  ///< every force field is
  bool hasGravity() const { return has_gravity_; }
  /// Mapped nodes with a mass move on curves: M then depends on x, and forces include the inertia of the curvature.
  bool hasCurvedInertia() const { return !curved_masses_.empty(); }

  // ---- changes between steps ----
  /// These components have been recreated: compiles those that act here, the integrator, and everything that depends on
  /// them. `t`: the present time [s].
  void componentsChanged(const std::vector<Component*>& changed, double t);
  void gravityChanged();
  /// Writes or reads whatever steps depend on besides x, v and components, see Component::serialize(); read it after those.
  /// `last`: times of the last step.
  void serialize(Archive& archive, const StepContext& last);

  // ---- external forces ----
  /// Adds an input on `state`, one of the independent states, or replaces the one with the same number. Nothing is
  /// compiled again, except when the first damping appears or the last one ends. Integrator::sceneChanged() is called
  /// unless only forces, targets, or the centre and radius of a ball have changed.
  void setInput(long number, const Input& input, State& state);
  void removeInput(long number);
  /// Null if there is none.
  const InputForces* inputs() const { return inputs_ && !inputs_->empty() ? inputs_.get() : nullptr; }

  // ---- parts ----
  ConstraintSet& constraints() { return constraints_; }
  const ConstraintSet& constraints() const { return constraints_; }
  const MappingChain& mappingChain() const { return mappings_; }
  MechanicalMatrix& matrix() { return matrix_; }
  const MechanicalMatrix& matrix() const { return matrix_; }

  mutable PhaseTimes times;
  mutable PhaseCounts counts;

 private:
  void bindStates();
  void inputsChanged(bool were_empty, bool were_damped);
  void checkLinearSolver() const;
  void computeGravity();
  void updateMasses(ConstRows x_all) const;
  void addCurvedInertia(ConstRows v_all, Rows f_now) const;
  void startForce(Rows out) const;  ///< out = gravity
  void noteForceEvaluation(ConstRows f_now);
  template <class Factor>
  void addMassProducts(ConstRows p, Rows out, Factor factor) const;

  Integrator& integrator_;
  mutable std::optional<LinearSolver*> solver_;  ///< linearSolver(), once it was asked for
  std::vector<MergedIntegrator> merged_;
  std::vector<Component*> components_;
  Actors actors_;
  MappingChain mappings_;
  ConstraintSet constraints_;
  PositionCorrections corrections_;
  MechanicalMatrix matrix_;
  std::unique_ptr<InputForces> inputs_;  ///< null until the first input; in the actors while there are inputs
  Vector gravity_force_;                 ///< constant, computed once
  std::vector<Mass*> curved_masses_;     ///< on mapped states with nonlinear mappings
  mutable Vector curve_, momentum_;      ///< work space, with such masses
  bool has_gravity_ = false;
  bool keeps_force_ = false;  ///< requestForce()
  long derivatives_revision_ = 0;
};

}  // namespace stroma
