// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "components/condensation/other_bodies.h"
#include "components/condensation/section_file.h"
#include "framework/simulation/system.h"

namespace stroma {

/// Which nodes the solver of a condensed body works with.
struct CondensationChoice {
  bool condensed = true;  ///< false: every free node is kept
  std::vector<int> kept;  ///< nodes of the (only) state that are kept; empty: those on the boundary of its cells
  bool dynamic = false;   ///< masses matter, and damping by stiffness or velocity is refused
};

/// A linear body as a solver of condensed systems sees it: f(x, t) = f(x_0, t) + K (x - x_0) with K constant. Free rows are
/// renumbered: [0, interior()) are inside, [interior(), free()) are kept: the boundary, nodes that an observer watches, nodes
/// whose motion is prescribed, few nodes whose loads change.
class CondensedBody {
 public:
  /// Finds what is held, inside and kept, without the other bodies; refuses with a sentence what is not linear, or not of this kind.
  void collect(System& system, const OtherBodies& others, const Integrator& integrator, const CondensationChoice& choice);

  Index interior() const { return interior_; }
  Index free() const { return Index(rows_.size()); }
  Index kept() const { return free() - interior_; }
  Index row(Index node) const { return rows_[node]; }          ///< of the system
  Index nodeOf(Index row) const { return node_of_row_[row]; }  ///< -1 when held
  /// New numbers for free nodes: order[new] = old.
  void renumber(const std::vector<Index>& order);
  const Vector& reference() const { return reference_; }  ///< x_0 [m], the initial positions
  const Vector& rest() const { return rest_; }            ///< positions of the rest shape [m]

  const Vector& zero() const { return still_; }
  /// K = -df/dx on all rows of the system.
  BlockMatrix stiffness() const;
  /// P (K + diag(shift)) P + s (I - P) on the free nodes; `shift` [N/m], shape (free) or empty. P lets nodes that slide
  /// keep their free directions, s is about the size of the diagonal.
  BlockMatrix matrix(const BlockMatrix& stiffness, const std::vector<double>& shift) const;
  /// What matrix() depends on beside `shift`: K, which rows are free, in which order, and how they are held.
  void addTo(ContentKey& key) const;
  /// Lumped masses of the free nodes [kg].
  std::vector<double> masses() const;
  /// Mass-proportional damping of the masses' own [1/s], shape (free).
  std::vector<double> massDamping() const;

  /// f(x_0) of all that does not change in time, gravity included, projected; shape (free, 3).
  std::vector<double> constantForce();
  /// Nodes on which forces change in time.
  const std::vector<Index>& timedNodes() const { return timed_nodes_; }
  /// After System::setTime(): f(x_0, t) of what changes in time, projected, to be read by timedForce().
  void updateTimedForces();
  Vec3 timedForce(Index node) const { return timed_force_[row(node)]; }

  /// Rows whose motion is prescribed, or held for a time only, have a mark; null when there are none.
  const std::vector<char>* movingRows() const { return moves_ ? &moving_ : nullptr; }
  /// Every constraint in force holds at all times.
  bool constraintsAreFixed() const { return constraints_are_fixed_; }
  /// The directions that a node has at all times: I unless it slides.
  Mat3 projector(Index node) const;

  /// Takes held directions out of a vector over nodes from `first` on, 3 numbers each.
  void projectNodes(Index first, double* vector) const;

  /// Sentences for the scene's author, as on loads that were taken for dead.
  const std::vector<std::string>& notes() const { return notes_; }
  /// Contact by barriers or penalties, whose forces are not linear.
  const std::vector<ForceField*>& contacts() const { return contacts_; }

 private:
  void refuseOtherKinds(const Integrator& integrator, bool dynamic);
  void sortFields(bool dynamic);
  void findHeld();
  std::vector<char> keptRows(const Integrator& integrator, const CondensationChoice& choice);
  void keepFewTimedRows(std::vector<char>& kept) const;
  void markBoundary(const State& state, std::vector<char>& kept);
  void findTimedNodes();
  void project(Vector& force) const;

  System* system_ = nullptr;
  const OtherBodies* others_ = nullptr;
  std::vector<ForceField*> stiff_, constant_, timed_, contacts_;
  std::vector<const ForceField*> dead_;  ///< follow the surface; taken at rest
  std::vector<Index> rows_, node_of_row_;
  Index interior_ = 0;
  std::vector<NodeProjector> held_;  ///< at all times, sorted by row
  std::vector<char> moving_;
  bool moves_ = false, constraints_are_fixed_ = true;
  Vector reference_, rest_, still_, timed_force_;
  std::vector<Index> timed_nodes_, timed_rows_;
  std::vector<std::string> notes_;
};

}  // namespace stroma
