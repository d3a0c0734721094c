// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "framework/algebra/linear_solver.h"
#include "framework/mechanics/force_field.h"
#include "framework/mechanics/mapping.h"
#include "framework/mechanics/mass.h"
#include "framework/mechanics/position_constraint.h"
#include "framework/mechanics/projective_constraint.h"
#include "framework/simulation/mapped_matrix.h"
#include "framework/simulation/node_groups.h"
#include "framework/simulation/shared_placements.h"
#include "framework/simulation/step.h"

namespace stroma {

class Integrator;

/// Wall time spent in the parts of a step [s].
struct PhaseTimes {
  double force = 0, product = 0, assembly = 0, solve = 0, observers = 0, total = 0;
};

/// Adds the wall time of its own life to a phase.
class PhaseTimer {
 public:
  explicit PhaseTimer(double& total) : total_(total) {}
  ~PhaseTimer() { total_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }
  PhaseTimer(const PhaseTimer&) = delete;
  PhaseTimer& operator=(const PhaseTimer&) = delete;

 private:
  double& total_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// The factors of the terms of a system's matrix. Rayleigh factors multiply each mass's and force field's own.
struct MatrixFactors {
  double mass = 0, stiffness = 0, damping = 0, rayleigh_mass = 0, rayleigh_stiffness = 0;
  bool operator==(const MatrixFactors&) const = default;
};

/// The unknowns below one integrator as one contiguous vector each, and flat lists of what acts on them. Independent
/// states come first (rows [0, independentRows())), mapped ones after them.
class System final : public SystemMatrix {
 public:
  /// Collects from `node` and below. Problems are thrown as ComponentError.
  System(Node& node, Integrator& integrator);

  // ---- unknowns; shape (allRows()) ----
  Vector x, v, f;
  Index allRows() const { return all_rows_; }
  Index independentRows() const { return independent_rows_; }

  const std::vector<State*>& states() const { return states_; }
  const std::vector<ForceField*>& forceFields() const { return force_fields_; }
  const std::vector<Mass*>& masses() const { return masses_; }
  const std::vector<ProjectiveConstraint*>& constraints() const { return constraints_; }
  const std::vector<PositionConstraint*>& positionConstraints() const { return position_constraints_; }
  /// Those whose child something acts on, and those that place children that nothing acts on: the latter are applied
  /// after each step and nowhere else.
  const std::vector<Mapping*>& mappings() const { return mappings_; }
  const std::vector<Mapping*>& passiveMappings() const { return passive_mappings_; }
  Integrator& integrator() const { return integrator_; }
  LinearSolver* linearSolver() const { return linear_solver_; }
  Node& node() const { return node_; }

  // ---- what integrators use ----
  /// f = sum of forces at (x, v), gravity included; prepares the stiffness at x. Not projected.
  void computeForce(ConstRows x, ConstRows v, Rows f);
  /// The same, plus the sum of (k + k_rayleigh rayleighStiffness of the field) K p for all fields, in one pass;
  /// System::f becomes the force alone where it was asked for.
  void computeForceAndProduct(ConstRows x, ConstRows v, ConstRows p, double k, double k_rayleigh, Rows out);
  /// An integrator that reads System::f after computeForceAndProduct() says so once; observers ask a State.
  void requestForce() { states_.front()->requestForce(); }
  /// The time [s] of forces that depend on it; beginStep() sets the end of the step.
  void setTime(double t);
  /// out += sum of (k + k_rayleigh rayleighStiffness of the field) K p, K of the last force; on independent rows.
  void addStiffnessProduct(ConstRows p, double k, double k_rayleigh, Rows out) const;
  void addMassProduct(ConstRows p, double factor, Rows out) const;
  /// out += sum of (rayleigh + rayleighMass of the mass) * factor * M p
  void addRayleighMassProduct(ConstRows p, double rayleigh, double factor, Rows out) const;
  /// 1 / m for each independent row, zero for rows held in all directions at all times; throws as requireMass(). To be
  /// used with project(): rows tied to others have the inverse of their group's mean. Kept up to date.
  const std::vector<double>& inverseLumpedMass();
  bool massIsDiagonal() const;
  /// Throws ComponentError naming a state or a node that can move and has no mass: integrators of dynamics call it
  /// once.
  void requireMass() const;

  /// Projects onto the free directions of constraints active at the time of beginStep().
  void project(Rows vector) const;
  /// Rows and projectors in force, sorted by row, at most one a row.
  const std::vector<NodeProjector>& projectors() const { return projectors_; }
  /// Rows that have one velocity; project() takes their mean.
  const NodeGroups& groups() const { return groups_; }
  /// Constraints at the end of the step: activates or ends them, projects velocities, and gives what has a prescribed
  /// motion the constant velocity that gets it there.
  void beginStep(const StepContext& context);
  /// Writes positions and velocities at the end of the step of what has a prescribed motion. endStep() does it for x
  /// and v; an integrator that solves for positions (statics) does it for its own.
  void placePrescribed(const StepContext& context, Rows x, Rows v) const;
  bool hasPrescribed() const { return !moving_projectors_.empty(); }
  /// After the integrator: prescribed motion and tied rows, exactly.
  void endStep(const StepContext& context);
  void applyMappings();  ///< passive ones too
  /// Position constraints after endStep(), for a step from positions `x_start`. Only when there are some.
  void enforcePositions(const StepContext& context, ConstRows x_start, StepReport& report);

  double kineticEnergy() const { return kineticEnergy(v); }
  double kineticEnergy(ConstRows v_then) const;  ///< [J]
  double potentialEnergy(ConstRows x) const;     ///< elastic + gravity + loads [J]
  double elasticEnergy(ConstRows x) const;       ///< force fields only [J]
  double gravityEnergy(ConstRows x) const;       ///< [J]
  bool isConservative() const;                   ///< every force field is

  // ---- the matrix of a linear solve ----
  /// Sets A = P (sum (m + m_r rayleighMass) M + sum (k + k_r rayleighStiffness) K + sum c C) P + (I - P), with the
  /// factors m, m_r, k, k_r, c in the order of masses, force fields and those that depend on velocity.
  SystemMatrix& matrix(const MatrixFactors& factors);
  Index rows() const override { return independent_rows_; }
  void multiply(ConstRows p, Rows out) const override;
  const BlockMatrix& assemble() override;
  const BlockMatrix& pattern() override {
    preparePattern();
    return matrix_;
  }
  void diagonalBlocks(std::vector<double>& blocks) const override;
  MatrixKey key() const override { return {identity().get(), pattern_revision_, revision_}; }
  bool symmetric() const override;
  bool prefersAssembled(int expected_products) const override;
  ConstRows positions() const override { return {x.rows().data, independent_rows_}; }
  std::string describeRow(Index row) const override;

  /// Empty, or a sentence: prescribed motions put a node at places without a common point, or x or v is not finite
  /// (with the state, the node and the component to suspect), or an elastic body is more than a million times its size
  /// at rest (a hundred times where elements have grown as much) and larger than at `before` [m]. It will not come
  /// back, and long before it overflows nothing about it means anything.
  std::string firstFault(ConstRows before);
  /// A sentence for every elastic body that is more than ten times its size at rest.
  std::vector<std::string> grownBodies() const;
  /// Throws ComponentError when a mass or a force field has a Rayleigh factor and `method` (a sentence's subject) has
  /// no damping: it would be ignored.
  void refuseRayleighFactors(const std::string& method) const;
  /// A line each for what runs and what is skipped, with the reason.
  std::vector<std::string> explain() const;

  mutable PhaseTimes times;
  struct Counts {
    long forces = 0, products = 0, assemblies = 0, gravity = 0;
  };
  mutable Counts counts;

 private:
  void collect();
  void findLinearSolver();
  void checkActors() const;
  void orderMappings();
  void applyActingMappings();
  void layOut();
  void preparePositionConstraints();
  void computeGravity();
  void startForce(Rows out) const;  ///< out = gravity
  void gatherConstraints(double t_start, double t_end);
  void gatherGroups();
  void reserveConstraints();
  void updateInverseMass();
  void aimAtPrescribed(const StepContext& context);
  void checkSharedPlaces(double start);
  std::string describeConflict(const SharedPlacements::Conflict& conflict) const;
  std::vector<double> lumpedMass() const;
  std::vector<char> rowsAlwaysHeld() const;
  double stiffnessFactor(const ForceField& field) const {
    return factors_.stiffness + factors_.rayleigh_stiffness * field.rayleigh_stiffness;
  }
  double massFactor(const Mass& mass) const { return factors_.mass + factors_.rayleigh_mass * mass.rayleigh_mass; }
  std::string firstNonFinite(bool x_good) const;
  std::string firstBurst(ConstRows before) const;
  void noteForceEvaluation(ConstRows f_now);
  void preparePattern() const;
  void addConstantParts(BlockMatrix& matrix);
  void addChangingParts(BlockMatrix& matrix);
  void eliminateConstraints();
  void eliminateProjectors();
  ConstRows onAllRows(ConstRows p, Vector& work, bool is_position) const;
  void pullBack(Rows all) const;
  void pullBackProduct(ConstRows p, double k, Rows all) const;
  template <class Factor>
  void addMassProducts(ConstRows p, Rows out, Factor factor) const;

  Node& node_;
  Integrator& integrator_;
  LinearSolver* linear_solver_ = nullptr;
  std::vector<State*> states_;
  std::vector<ForceField*> force_fields_;
  std::vector<ForceField*> stiff_fields_;   ///< those with a stiffness
  std::vector<ForceField*> damped_fields_;  ///< those that depend on velocity
  std::vector<ForceField*> timed_fields_;   ///< those that depend on time
  std::vector<Mass*> masses_;
  std::vector<ProjectiveConstraint*> constraints_;
  std::vector<PositionConstraint*> position_constraints_;
  std::vector<Mapping*> mappings_, passive_mappings_;
  Index all_rows_ = 0, independent_rows_ = 0;

  Vector gravity_force_;    ///< constant, computed once
  double burst_size_ = -1;  ///< [m], see firstFault(); -1: not looked up yet
  bool has_gravity_ = false;
  std::vector<NodeProjector> projectors_, gathered_;
  std::vector<NodeProjector> velocity_projectors_;  ///< of constraints that also project velocities
  std::vector<NodeProjector> moving_projectors_;    ///< of prescribed motion
  std::vector<NodeProjector> placed_;               ///< the same without the rows that only follow their group
  mutable SharedPlacements shared_places_;          ///< of nodes with more than one prescribed motion
  mutable std::string misplaced_;                   ///< the sentence when such a node has no place
  std::vector<Index> projector_of_row_;             ///< shape (independentRows()): index in projectors_ or -1
  std::vector<Tie> gathered_ties_;
  NodeGroups groups_;
  std::vector<double> inverse_mass_;  ///< [1/kg], shape (independentRows()), when it was asked for
  bool wants_inverse_mass_ = false;
  Vector target_x_, target_v_;       ///< work space of prescribed motion
  bool constraints_change_ = false;  ///< some constraint ends or depends on time

  MatrixFactors factors_;
  Mobility mobility_;          ///< of position constraints
  Vector position_reference_;  ///< shape (independentRows()), only with position constraints
  Vector position_before_;     ///< what a turn of the position constraints started from

  long pattern_revision_ = 0;  ///< of the matrix; its pattern is that of all times, so it stays
  long revision_ = 0, assembled_revision_ = -1;
  bool stiffness_varies_ = false;  ///< some K or C may change with x or v
  bool mappings_linear_ = true;
  mutable BlockMatrix matrix_;
  mutable MappedMatrix mapped_matrix_;  ///< only with mappings
  mutable bool pattern_ready_ = false;
  mutable Index block_count_ = -1;     ///< of the pattern, -1 until it was built once
  std::vector<double> constant_part_;  ///< values of the terms that do not change, shape (blocks, 9)
  MatrixFactors constant_factors_;
  bool constant_part_ready_ = false;

  /// Work space, shape (allRows()), only with mappings: positions, velocities, a direction and a force on all rows.
  mutable Vector mapped_x_, mapped_v_, mapped_p_, mapped_f_;
  Vector last_force_;  ///< of the last evaluation, shape (allRows()), only with mappings that are not linear
};

}  // namespace stroma
