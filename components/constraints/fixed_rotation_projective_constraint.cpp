// SPDX-License-Identifier: LGPL-2.1-or-later
// FixedRotationProjectiveConstraint: rigid frames that do not turn about some of the fixed axes.
//
//   P = I for the centre,   P = diag(1 - a_x, 1 - a_y, 1 - a_z) for the turn,   a = FixedXRotation, FixedYRotation, FixedZRotation
//
// The components of the angular velocity about these axes do not change. Without indices this applies to every frame. With two
// fixed axes a frame can only rotate about the third; with three it keeps its orientation.
//
// Source: the name and the three attributes are SOFA's, which does not change the velocity but removes rotations about the
// fixed axes from the orientation: this is the same for a frame that rotates about one axis, not for one that rotates about
// several.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-10"/>
//   <MechanicalObject template="Rigid3" position="0 0 0  0 0 0 1   1 0 0  0 0 0 1"/>
//   <UniformMass totalMass="2" inertia="0.1 0.2 0.3"/>
//   <ConstantForceField forces="0 0 0  1 2 3"/>
//   <FixedRotationProjectiveConstraint indices="1" FixedXRotation="true" FixedZRotation="true"/>
// </Node>
#include "components/constraints/held_nodes.h"
#include "framework/mechanics/node_indices.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class FixedRotation final : public HeldNodes {
 public:
  void declare(DataTable& table) override {
    HeldNodes::declare(table);
    table.find("indices")->help("frames that do not turn; every frame by default");
    table.add("FixedXRotation", held_[0]).help("no turn about x");
    table.add("FixedYRotation", held_[1]).help("no turn about y");
    table.add("FixedZRotation", held_[2]).help("no turn about z");
  }

  void init() override {
    if (data().find("indices")->isSet() || data().find("fixAll")->isSet()) {
      HeldNodes::init();
    } else {
      ProjectiveConstraint::init();
      setNodes(allNodes(state()));
    }
    if (!state().hasFrames())
      throw ComponentError("the nodes of " + state().path() + " have no orientation", "a state of template Rigid3");
    if (!held_[0] && !held_[1] && !held_[2])
      warn("no axis is fixed: the constraint has no effect", "FixedXRotation, FixedYRotation or FixedZRotation");
    Mat3 free = Mat3::Identity();
    for (int axis = 0; axis < 3; ++axis)
      if (held_[axis]) free(axis, axis) = 0;
    setProjectors({Mat3::Identity(), free});
  }

 protected:
  bool takesAllRows() const override { return true; }

 private:
  bool held_[3] = {false, false, false};
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(fixed_rotation_projective_constraint) {
  factory.add<stroma::FixedRotation>("FixedRotationProjectiveConstraint", "Holds rigid frames against turns about some axes");
}
