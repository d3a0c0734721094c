// SPDX-License-Identifier: LGPL-2.1-or-later
// PartialFixedProjectiveConstraint: nodes that are held along some of the axes.
//
//   P_i = diag(1 - d_x, 1 - d_y, 1 - d_z), d = fixedDirections
//
// The components of the velocity along the held axes do not change; projectVelocity sets them to zero. Two constraints
// on one node leave it the directions that both leave free. After `endTime` the nodes are free.
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
#include <numeric>

#include "framework/mechanics/node_indices.h"
#include "framework/mechanics/projective_constraint.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class PartialFixedProjectiveConstraint final : public ProjectiveConstraint {
 public:
  void declare(DataTable& table) override {
    ProjectiveConstraint::declare(table);
    table.add("indices", indices_).help("nodes to hold");
    table.add("fixAll", fix_all_).help("hold every node");
    table.add("fixedDirections", directions_).help("for x, y and z: 1 held, 0 free");
    table.add("projectVelocity", project_velocity_)
        .alias("activate_projectVelocity")
        .help("also set the velocity along the held directions to zero");
    table.addVisualOnly("topology");
  }

  void init() override {
    ProjectiveConstraint::init();
    if (directions_.size() != 3)
      throw ComponentError(fmt::format("fixedDirections has {} values", directions_.size()),
                           "3 values, one for each of x, y, z");
    if (std::none_of(directions_.begin(), directions_.end(), [](bool held) { return held; }))
      warn("fixedDirections holds no direction: the constraint does nothing", "write 1 for each direction to hold");
    for (int c = 0; c < 3; ++c) projector_(c, c) = directions_[std::size_t(c)] ? 0 : 1;
    if (fix_all_) {
      nodes_.resize(std::size_t(state().size()));
      std::iota(nodes_.begin(), nodes_.end(), 0);
      return;
    }
    if (!data().find("indices")->isSet())
      throw ComponentError("no indices: which nodes are held?",
                           "indices=\"0 3 7\", indices=\"@roi.indices\" or fixAll=\"true\"");
    nodes_ = checkedNodes(indices_, state(), "indices");
  }

  void addProjectors(double, std::vector<NodeProjector>& out) const override {
    for (Index node : nodes_) out.push_back({state().firstRow() + node, projector_});
  }
  bool projectsVelocity() const override { return project_velocity_; }

 private:
  std::vector<int> indices_;
  std::vector<bool> directions_{true, true, true};
  bool fix_all_ = false, project_velocity_ = false;
  std::vector<Index> nodes_;
  Mat3 projector_ = Mat3::Zero();
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(partial_fixed_projective_constraint) {
  factory.add<stroma::PartialFixedProjectiveConstraint>("PartialFixedProjectiveConstraint",
                                                        "Holds nodes along some of the axes");
}
