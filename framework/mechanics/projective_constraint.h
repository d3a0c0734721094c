// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/algebra/block_matrix.h"
#include "framework/mechanics/state.h"

namespace stroma {

/// A node whose change of velocity is limited to the image of `projector` (symmetric, P P = P): zero holds the node,
/// I - n n^T lets it slide in a plane.
struct NodeProjector {
  Index row = 0;
  Mat3 projector = Mat3::Zero();
};

/// Two rows of the system with a common velocity; several ties form a group. The projector of a group of n is the mean
/// (each block 1/n). It is orthogonal, so P M P and P f give the group the sum of its masses and forces.
struct Tie {
  Index a = 0, b = 0;
  bool operator==(const Tie&) const = default;
};

/// Linear relations sum_j c_j . u_j = 0 between displacements u_j of rows; the coefficients c_j are vectors.
struct LinearRelations {
  struct Term {
    Index row = 0;
    Vec3 coefficients = Vec3::Zero();
    Vec3 rest = Vec3::Zero();  ///< [m], position of the row at zero displacement
    bool operator==(const Term&) const = default;
  };
  std::vector<Term> terms;
  std::vector<Index> ends;  ///< one past the last term of each relation
  Index count() const { return Index(ends.size()); }
  const Term* begin(Index relation) const { return terms.data() + (relation == 0 ? 0 : ends[relation - 1]); }
  const Term* end(Index relation) const { return terms.data() + ends[relation]; }
  void clear() { terms.clear(), ends.clear(); }
  bool operator==(const LinearRelations&) const = default;
};

/// Constraints on the velocities of nodes. A constraint only lists its projectors, ties and relations. System merges
/// them, projects vectors and eliminates them from matrices.
///
/// Prescribed motion: at the start of a step System gives constrained directions the velocity that takes them to the
/// positions of prescribe() at its end, so integrators need no special case. After the step prescribe() sets positions
/// and velocities exactly.
class ProjectiveConstraint : public Component {
 public:
  std::string roleText() const override { return "projective constraint"; }
  void declare(DataTable& table) override;  ///< mstate, endTime and SOFA's drawing attributes
  void init() override;                     ///< finds the state
  State& state() const { return *state_; }
  /// Every state whose nodes it constrains or reads.
  virtual std::vector<State*> states() const { return {state_}; }
  /// True if it is active in a step from t to t_end. Default: while t is before endTime.
  virtual bool activeIn(double t, double /*t_end*/) const { return end_time_ < 0 || t < end_time_; }
  double endTime() const { return end_time_; }  ///< [s]; negative: never ends

  /// Appends the projectors at time t (rows of the system).
  virtual void addProjectors(double t, std::vector<NodeProjector>& out) const = 0;
  /// Appends the pairs of rows that move as one.
  virtual void addTies(std::vector<Tie>&) const {}
  /// Appends relations between displacements.
  virtual void addRelations(LinearRelations&) const {}
  /// True if projectors, and activeIn() apart from endTime, do not depend on time.
  virtual bool isConstant() const { return true; }
  /// True if constrained velocities are also set to zero, not only kept from changing.
  virtual bool projectsVelocity() const { return false; }

  /// Appends rows that follow others without acting on them: the forces on these rows are discarded.
  virtual void addUnansweredRows(std::vector<Index>&) const {}

  /// Initial positions [m] and velocities [m/s], if they differ from those of the states; `t`: the start time [s].
  virtual void placeStart(double /*t*/, Rows /*x*/, Rows /*v*/) const {}

  // ---- prescribed motion ----
  virtual bool prescribesMotion() const { return false; }
  /// Called at the start of each step in which it is active, with the positions that the motion starts from.
  virtual void beginMotion(double /*t*/, ConstRows /*x*/) {}
  /// Writes positions and velocities at time t in the constrained directions; may read other rows.
  virtual void prescribe(double /*t*/, Rows /*x*/, Rows /*v*/) const {}

 protected:
  Link<State> mstate_{"mechanical state"};
  virtual bool takesAllRows() const { return false; }  ///< as ForceField's

 private:
  State* state_ = nullptr;
  double end_time_ = -1;
};

}  // namespace stroma
