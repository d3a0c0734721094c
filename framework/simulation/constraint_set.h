// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "framework/simulation/prescribed_motion.h"
#include "framework/simulation/relation_clusters.h"

namespace stroma {

/// The projective constraints of a system: which directions of which rows may change, which rows move together, which
/// are coupled by linear relations, and which follow a prescribed motion.
class ConstraintSet {
 public:
  /// Reads nothing yet; `actors` must outlive this object.
  explicit ConstraintSet(const Actors& actors);
  ConstraintSet(const ConstraintSet&) = delete;
  /// Moves nodes to their initial positions at time `start` [s] and finds the active constraints; x and v of shape (all rows).
  /// Throws ComponentError for nodes that cannot satisfy their constraints.
  void compile(double start, Rows x, Rows v);

  const std::vector<ProjectiveConstraint*>& all() const { return actors_.constraints; }
  /// Active rows and projectors, sorted by row, at most one per row.
  const std::vector<NodeProjector>& projectors() const { return projectors_; }
  /// Index in projectors() of a row, -1 if it is unconstrained.
  Index projectorOf(Index row) const { return projector_of_row_[std::size_t(row)]; }
  /// Rows with a common velocity; project() takes their mean.
  const NodeGroups& groups() const { return groups_; }
  /// Active linear relations; project() satisfies them.
  const RelationClusters& relations() const { return relations_; }
  /// The rows whose matrix blocks are ever mixed by ties and relations.
  NodeGroups mixedRows() const;
  /// Increases when projectors, groups or relations change.
  long revision() const { return revision_; }
  /// Some constraint ends or depends on time.
  bool change() const { return change_; }

  /// Projects onto the free directions of constraints active at the time of begin(); shape (independent rows) or more.
  void project(Rows vector) const;
  /// The same for accelerations M^-1 f, with inverseLumpedMass(), and for displacements and velocities that include the effect
  /// of constraint forces: if the nodes of a relation differ in mass, it moves the lighter ones more.
  void projectAcceleration(Rows a) const;
  /// Starts a step: activates or ends constraints, projects velocities, and gives rows with a prescribed motion the constant
  /// velocity that reaches its end.
  void begin(const StepContext& context, ConstRows x, Rows v);
  /// Ends a step: sets prescribed motion and tied rows exactly. False if there are none.
  bool end(const StepContext& context, Rows x, Rows v) const;
  /// Writes positions and velocities of prescribed motions at the end of the step. end() does it; an integrator that
  /// solves for positions (statics) calls it for its own vectors.
  void placePrescribed(const StepContext& context, Rows x, Rows v) const {
    placePrescribed(context, context.t_end, x, v);
  }
  /// The same at a time t [s] within the step, for methods with several stages.
  void placePrescribed(const StepContext& context, double t, Rows x, Rows v) const;
  bool hasPrescribed() const { return !motion_.empty(); }
  /// Empty, or a sentence: prescribed motions of a node conflict, or violate a relation.
  const std::string& misplaced() const { return motion_.misplaced().empty() ? broken_ : motion_.misplaced(); }

  // ---- changes between steps ----
  /// Attributes of constraints or masses have changed at time `t` [s]. Newly constrained rows stop where they are.
  void componentsChanged(double t, Rows v);
  /// Restores the constraints active in `last`, the last step of the run that continues.
  void resume(const StepContext& last);

  // ---- masses and fixed rows ----
  /// Throws ComponentError naming a state or a node that can move and has no mass: integrators of dynamics call it
  /// once.
  void requireMass() const;
  /// 1/m of each independent row, zero for permanently fixed rows; throws as requireMass() does. Use it with project(): tied
  /// rows have the inverse of the mean mass of their group. Kept up to date.
  const std::vector<double>& inverseLumpedMass();

 private:
  void holdUnusedDirections(std::vector<NodeProjector>& out) const;
  void reserve(double start);
  void gather(double t_start, double t_end);
  bool gatherRelations(double t_start, double t_end);
  void refuseTurningRows() const;
  void placeRelations(Rows x, Rows v) const;
  void meetGroups(double start, Rows x, Rows v) const;
  void updateInverseMass();
  std::vector<double> relationWeights() const;

  const Actors& actors_;
  NodeGroups groups_;
  PrescribedMotion motion_;
  std::vector<NodeProjector> projectors_, gathered_;
  std::vector<NodeProjector> velocity_projectors_;  ///< of constraints that also project velocities
  std::vector<Index> projector_of_row_;             ///< shape (independent rows)
  std::vector<Tie> gathered_ties_;
  RelationClusters relations_;
  LinearRelations gathered_relations_;
  mutable std::string broken_;        ///< see misplaced()
  std::vector<double> inverse_mass_;  ///< [1/kg], shape (independent rows), computed on demand
  bool wants_inverse_mass_ = false, change_ = false;
  long revision_ = 0;
};

}  // namespace stroma
