// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "framework/simulation/prescribed_motion.h"
#include "framework/simulation/relation_clusters.h"

namespace stroma {

/// The projective constraints of a system: which directions of which rows may change, which rows move as one, which
/// are tied by linear relations, and which follow a prescribed motion.
class ConstraintSet {
 public:
  /// Looks at nothing yet; `actors` outlives this.
  explicit ConstraintSet(const Actors& actors);
  ConstraintSet(const ConstraintSet&) = delete;
  /// Puts nodes where they start at time `start` [s] and looks up what holds there; x and v of shape (all rows). Throws
  /// ComponentError for nodes that cannot be where constraints put them.
  void compile(double start, Rows x, Rows v);

  const std::vector<ProjectiveConstraint*>& all() const { return actors_.constraints; }
  /// Rows and projectors in force, sorted by row, at most one per row.
  const std::vector<NodeProjector>& projectors() const { return projectors_; }
  /// Index in projectors() of a row, -1 where nothing holds it.
  Index projectorOf(Index row) const { return projector_of_row_[std::size_t(row)]; }
  /// Rows that have one velocity; project() takes their mean.
  const NodeGroups& groups() const { return groups_; }
  /// Linear relations in force; project() respects them.
  const RelationClusters& relations() const { return relations_; }
  /// The rows whose blocks ties and relations mix in a matrix, at one time or another.
  NodeGroups mixedRows() const;
  /// Grows when projectors, groups or relations change.
  long revision() const { return revision_; }
  /// Some constraint ends or depends on time.
  bool change() const { return change_; }

  /// Projects onto the free directions of constraints active at the time of begin(); shape (independent rows) or more.
  void project(Rows vector) const;
  /// The same for accelerations, M^-1 f with the inverseLumpedMass(), and for ways and velocities that hold what the
  /// constraints' forces did: where nodes of a relation have different masses, it moves the lighter ones more.
  void projectAcceleration(Rows a) const;
  /// The start of a step: activates or ends constraints, projects velocities, and gives what has a prescribed motion the
  /// constant velocity that gets it there.
  void begin(const StepContext& context, ConstRows x, Rows v);
  /// The end of a step: prescribed motion and tied rows, exactly. False when there are none.
  bool end(const StepContext& context, Rows x, Rows v) const;
  /// Writes positions and velocities at the end of the step of what has a prescribed motion. end() does it; an
  /// integrator that solves for positions (statics) does it for its own.
  void placePrescribed(const StepContext& context, Rows x, Rows v) const {
    placePrescribed(context, context.t_end, x, v);
  }
  /// The same at a time t [s] within the step: a method with several stages sees the motion at each.
  void placePrescribed(const StepContext& context, double t, Rows x, Rows v) const;
  bool hasPrescribed() const { return !motion_.empty(); }
  /// Empty, or a sentence: prescribed motions put a node at places without a common point, or break a relation.
  const std::string& misplaced() const { return motion_.misplaced().empty() ? broken_ : motion_.misplaced(); }

  // ---- changes between steps ----
  /// Attributes of constraints or masses have changed at time `t` [s]. What is newly held stops where it is.
  void componentsChanged(double t, Rows v);
  /// What holds is what held in `last`, the last step of the run that goes on.
  void resume(const StepContext& last);

  // ---- masses and what is held ----
  /// Throws ComponentError naming a state or a node that can move and has no mass: integrators of dynamics call it
  /// once.
  void requireMass() const;
  /// 1/m of each independent row, zero for rows held in all directions at all times; throws as requireMass(). To be used
  /// with project(): rows tied to others have the inverse of their group's mean. Kept up to date.
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
  std::vector<double> inverse_mass_;  ///< [1/kg], shape (independent rows), when it was asked for
  bool wants_inverse_mass_ = false, change_ = false;
  long revision_ = 0;
};

}  // namespace stroma
