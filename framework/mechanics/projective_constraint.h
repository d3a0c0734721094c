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

/// Two rows of the system that have one velocity; several ties make a group. The projector of a group of n is the mean
/// (each block 1/n): orthogonal, so P M P and P f give the group the sum of its masses and of its forces.
struct Tie {
  Index a = 0, b = 0;
  bool operator==(const Tie&) const = default;
};

/// Linear relations sum_j c_j . u_j = 0 between displacements u_j of rows; the coefficients c_j are vectors.
struct LinearRelations {
  struct Term {
    Index row = 0;
    Vec3 coefficients = Vec3::Zero();
    Vec3 rest = Vec3::Zero();  ///< [m], where the row has no displacement
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

/// Constraints on the velocities of nodes. System merges all projectors, ties and relations, projects vectors with
/// them and eliminates them from matrices; a constraint only says which.
///
/// Prescribed motion: at the start of a step System gives the held directions the velocity that carries them to where
/// prescribe() puts them at the step's end, so that integrators need to know nothing of it; after the step prescribe()
/// places positions and velocities exactly.
class ProjectiveConstraint : public Component {
 public:
  std::string roleText() const override { return "projective constraint"; }
  void declare(DataTable& table) override;  ///< mstate, endTime and SOFA's drawing attributes
  void init() override;                     ///< finds the state
  State& state() const { return *state_; }
  /// Every state whose nodes it holds or reads.
  virtual std::vector<State*> states() const { return {state_}; }
  /// True in a step from t to t_end. The base class: while t is before endTime.
  virtual bool activeIn(double t, double /*t_end*/) const { return end_time_ < 0 || t < end_time_; }
  double endTime() const { return end_time_; }  ///< [s]; negative: never ends

  /// Appends the projectors at time t (rows of the system).
  virtual void addProjectors(double t, std::vector<NodeProjector>& out) const = 0;
  /// Appends the pairs of rows that move as one.
  virtual void addTies(std::vector<Tie>&) const {}
  /// Appends relations between displacements.
  virtual void addRelations(LinearRelations&) const {}
  /// True when projectors, and activeIn() but for endTime, do not depend on time.
  virtual bool isConstant() const { return true; }
  /// True when held velocities are also set to zero, not only kept from changing.
  virtual bool projectsVelocity() const { return false; }

  /// Appends rows that follow others one way: forces on them are not passed on to the rows that they follow.
  virtual void addUnansweredRows(std::vector<Index>&) const {}

  /// Positions [m] and velocities [m/s] before the first step, where they are not those of the states; `t`: the start.
  virtual void placeStart(double /*t*/, Rows /*x*/, Rows /*v*/) const {}

  // ---- prescribed motion ----
  virtual bool prescribesMotion() const { return false; }
  /// Called at the start of each step in which it is active, with the positions there: what the motion starts from.
  virtual void beginMotion(double /*t*/, ConstRows /*x*/) {}
  /// Writes positions and velocities at time t in the directions that it holds; may read other rows.
  virtual void prescribe(double /*t*/, Rows /*x*/, Rows /*v*/) const {}

 protected:
  Link<State> mstate_{"mechanical state"};
  virtual bool takesAllRows() const { return false; }  ///< as ForceField's

 private:
  State* state_ = nullptr;
  double end_time_ = -1;
};

}  // namespace stroma
