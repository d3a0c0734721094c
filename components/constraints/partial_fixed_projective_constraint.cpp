// SPDX-License-Identifier: LGPL-2.1-or-later
// PartialFixedProjectiveConstraint: nodes that are fixed along some of the axes.
//
//   P_i = diag(1 - d_x, 1 - d_y, 1 - d_z), d = fixedDirections
//
// A rigid frame has six: x, y and z of its centre, and of its turn about fixed axes. Of nodes that are numbers there is one
// for each. The components of the velocity along the fixed axes do not change; projectVelocity sets them to zero. With two
// constraints on one node it is free in the directions that both leave free. From `endTime` on the nodes are free.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerExplicitSolver/>
//   <MechanicalObject position="0 0 0  1 0 0  2 0 0"/>
//   <UniformMass totalMass="3"/>
//   <PartialFixedProjectiveConstraint indices="0 2" fixedDirections="0 1 0"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>

#include "components/constraints/held_nodes.h"
#include "components/constraints/row_keys.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class PartialFixedProjectiveConstraint final : public HeldNodes {
 public:
  void declare(DataTable& table) override {
    HeldNodes::declare(table);
    table.find("fixAll")->recompiled();
    table.add("fixedDirections", directions_)
        .recompiled()
        .help("for x, y and z, for frames also rotations about them, or for each number: 1 fixed, 0 free");
    table.add("projectVelocity", project_velocity_)
        .alias("activate_projectVelocity")
        .help("also set the velocity along the fixed directions to zero");
  }

  void init() override {
    HeldNodes::init();
    if (std::none_of(directions_.begin(), directions_.end(), [](bool held) { return held; }))
      warn("fixedDirections selects no direction: the constraint has no effect", "write 1 for each direction to fix");
    setProjectors(freeDirections(directions_, state(), "fixedDirections"));
  }
  bool projectsVelocity() const override { return project_velocity_; }

 protected:
  bool takesAllRows() const override { return true; }

 private:
  std::vector<bool> directions_{true, true, true};
  bool project_velocity_ = false;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(partial_fixed_projective_constraint) {
  factory.add<stroma::PartialFixedProjectiveConstraint>("PartialFixedProjectiveConstraint",
                                                        "Holds nodes along some of the axes");
}
