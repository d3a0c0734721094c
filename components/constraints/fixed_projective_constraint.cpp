// SPDX-License-Identifier: LGPL-2.1-or-later
// FixedProjectiveConstraint: nodes whose velocity does not change.
//
//   P_i = 0 for each listed node: the change of velocity, and the residual force, are projected to zero
//
// A listed node that starts with a velocity keeps it; activate_projectVelocity sets it to zero. From `endTime` on the nodes
// are free. The nodes must be named: `indices`, or `fixAll` for all of them. A rigid frame is fixed with its orientation;
// FixedTranslationProjectiveConstraint fixes only its centre, and is the same for points. With inMatrix="false" the nodes are
// not reset after a step, and stiffness couplings drag them along: SOFA does so with FixedTranslation.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerExplicitSolver/>
//   <MechanicalObject position="0 0 0  1 0 0  2 0 0"/>
//   <UniformMass totalMass="3"/>
//   <FixedProjectiveConstraint indices="0 2"/>
// </Node>
#include "components/constraints/held_nodes.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class FixedProjectiveConstraint final : public HeldNodes {
 public:
  void declare(DataTable& table) override {
    HeldNodes::declare(table);
    table.find("fixAll")->recompiled();
    table.add("activate_projectVelocity", project_velocity_).help("also set the velocity of the nodes to zero");
    declareMatrix(table);
    table.addVisualOnly("coordinates");
  }
  void init() override {
    HeldNodes::init();
    if (!(state().hasFrames() && type() == "FixedTranslationProjectiveConstraint")) holdAllRows();
  }
  bool projectsVelocity() const override { return project_velocity_; }

 protected:
  bool takesAllRows() const override { return true; }

 private:
  bool project_velocity_ = false;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(fixed_projective_constraint) {
  factory.add<stroma::FixedProjectiveConstraint>("FixedProjectiveConstraint", "Holds nodes in place");
  factory.add<stroma::FixedProjectiveConstraint>("FixedTranslationProjectiveConstraint",
                                                 "Holds nodes in place, and leaves frames free to turn");
}
