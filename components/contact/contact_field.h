// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "components/contact/body_list.h"
#include "components/contact/contact_attributes.h"
#include "components/contact/contact_obstacles.h"
#include "components/contact/contact_outputs.h"
#include "framework/mechanics/force_field.h"
#include "framework/mechanics/open_choices.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mechanics/step_limiter.h"

namespace stroma::contact {

/// A contact by forces: its bodies and obstacles as attributes, and the derivatives of the last addForce().
class ContactField : public ForceField, public OpenChoices, public HasSolvePotential, public DrawnObstacles {
 public:
  /// mstate, topology, those of BodyList, contactDistance, stiffness, thickness, coefficients of friction, selfContact and obstacles.
  void declare(DataTable& table) override;
  void init() override;
  std::vector<State*> states() const override { return bodies_; }
  bool acts() const override { return !terms_.empty() || !friction_.terms().empty(); }
  void addStiffnessProduct(ConstRows dx, double factor, Rows df) const override;
  void addStiffness(double factor, BlockMatrix& matrix) const override;
  void addStiffnessDiagonal(double factor, std::vector<double>& blocks) const override;
  Cost cost() const override;
  /// With friction, whose pressures and directions are lagged in a solve.
  bool hasSolvePotential() const override { return friction_.acts(); }
  double solvePotential(ConstRows x) const override;
  long patternRevision() const override { return pattern_revision_; }
  std::string choice() const override;
  void addShapes(std::vector<Shape>& shapes) const override { contact::addShapes(law_, shapes); }
  Vec3 shapesMovedBy() const override { return law_.moved; }

 protected:
  /// Called when rows are known: sets up the surfaces of the law, and the default of contactDistance.
  void compileSurfaces();
  /// Sets x_ to the positions at x with obstacles moved by `moved`.
  void gather(ConstRows x, const Vec3& moved) const { law_.surfaces.gather(x, moved, x_), law_.candidates.placedAt(x_); }

  // ---- attributes ----
  BarrierLaw law_;
  Friction friction_;
  double slip_velocity_ = 1e-4;
  bool self_ = true;
  BodyList listed_;
  TopologyLink topology_;
  Obstacles obstacles_;
  Outputs outputs_;

  std::vector<State*> bodies_;
  double mean_edge_ = 0;  ///< [m]
  long pattern_revision_ = 0;
  mutable std::vector<Vec3> x_;  ///< of all vertices; work space
  std::vector<Vec3> start_;      ///< the same at the start of the step
  Vec3 moved_at_start_ = Vec3::Zero();
  Terms terms_;  ///< of the last force

 private:
  double stiffness_ = 0;
};

}  // namespace stroma::contact
