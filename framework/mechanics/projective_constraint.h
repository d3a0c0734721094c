// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/mechanics/state.h"

namespace stroma {

/// A node whose change of velocity is limited to the image of `projector` (symmetric, P P = P): zero holds the node,
/// I - n n^T lets it slide in a plane.
struct NodeProjector {
  Index row = 0;
  Mat3 projector = Mat3::Zero();
};

/// Constraints that act node by node. System merges all projectors into one list, projects vectors with it and
/// eliminates it from matrices; a constraint only says which.
class ProjectiveConstraint : public Component {
 public:
  std::string roleText() const override { return "projective constraint"; }
  void declare(DataTable& table) override;  ///< mstate, endTime and SOFA's drawing attributes
  void init() override;                     ///< finds the state
  State& state() const { return *state_; }
  double endTime() const { return end_time_; }  ///< [s]; negative: never ends
  bool activeAt(double t) const { return end_time_ < 0 || t <= end_time_; }

  /// Appends the projectors at time t (rows of the system).
  virtual void addProjectors(double t, std::vector<NodeProjector>& out) const = 0;
  /// True when addProjectors does not depend on t (endTime is handled by the System).
  virtual bool isConstant() const { return true; }
  /// Imposes prescribed positions and velocities at the end of a step from t to t + dt, before forces are evaluated.
  virtual void impose(double /*t*/, double /*dt*/, Rows /*x*/, Rows /*v*/) const {}
  /// True when held velocities are also set to zero, not only kept from changing.
  virtual bool projectsVelocity() const { return false; }

 protected:
  Link<State> mstate_{"mechanical state"};

 private:
  State* state_ = nullptr;
  double end_time_ = -1;
};

}  // namespace stroma
