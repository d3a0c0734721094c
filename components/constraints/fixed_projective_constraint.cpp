// SPDX-License-Identifier: LGPL-2.1-or-later
// FixedProjectiveConstraint: nodes whose velocity does not change.
//
//   P_i = 0 for each listed node: the change of velocity, and the residual force, are projected to zero
//
// A listed node that starts with a velocity keeps it; activate_projectVelocity sets it to zero. After `endTime` the
// nodes are free. The nodes must be named: `indices`, or `fixAll` for all of them.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerExplicitSolver/>
//   <MechanicalObject position="0 0 0  1 0 0  2 0 0"/>
//   <UniformMass totalMass="3"/>
//   <FixedProjectiveConstraint indices="0 2"/>
// </Node>
#include <numeric>

#include "framework/mechanics/node_indices.h"
#include "framework/mechanics/projective_constraint.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class FixedProjectiveConstraint final : public ProjectiveConstraint {
 public:
  void declare(DataTable& table) override {
    ProjectiveConstraint::declare(table);
    table.add("indices", indices_).help("nodes to hold");
    table.add("fixAll", fix_all_).help("hold every node");
    table.add("activate_projectVelocity", project_velocity_).help("also set the velocity of the nodes to zero");
    table.addVisualOnly("topology");
  }

  void init() override {
    ProjectiveConstraint::init();
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
    for (Index node : nodes_) out.push_back({state().firstRow() + node, Mat3::Zero()});
  }
  bool projectsVelocity() const override { return project_velocity_; }

 private:
  std::vector<int> indices_;
  bool fix_all_ = false, project_velocity_ = false;
  std::vector<Index> nodes_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(fixed_projective_constraint) {
  factory.add<stroma::FixedProjectiveConstraint>("FixedProjectiveConstraint", "Holds nodes in place");
}
