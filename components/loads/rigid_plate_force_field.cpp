// SPDX-License-Identifier: LGPL-2.1-or-later
// RigidPlateForceField: a rigid plate that presses on nodes, with reaction, so that a force can push it.
//
// The plate is a separate node (`plate`, plateNode), pushed by a load and guided by constraints: its face is the plane with
// the unit normal n, at `offset` along n from that node. With g = n.(x_p - x) + offset the depth of a node behind the face,
// where g > 0:
//
//   E = k/2 g^2,   f = k g n,   f_p = -sum of f,   df/dx = -k n n^T
//
// Forces on plate and body are equal and opposite: momentum is conserved. The plate keeps its direction; nodes slide on it
// without friction. bilateral glues nodes to the face along n: it also pulls. A force F on a plate in equilibrium is the sum
// of k g: with n equally loaded nodes the depth is F/(n k). The plate needs a mass in dynamics. In statics it needs contact at
// the start, or bilateral: otherwise nothing supports it along n.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="200" tolerance="1e-12"/>
//   <Node name="plate">
//     <MechanicalObject name="dofs" position="0.5 1 0.5"/>
//     <UniformMass totalMass="0.5"/>
//     <PartialFixedProjectiveConstraint indices="0" fixedDirections="1 0 1"/>
//     <LinearForceField points="0" times="0 1" forces="0 0 0  0 -3 0"/>
//   </Node>
//   <Node name="body">
//     <MechanicalObject position="0 0 0  1 0 0  0 0 1  1 0 1  0 1 0  1 1 0  0 0.9 1  1 1.1 1"/>
//     <UniformMass totalMass="0.1"/>
//     <SpringForceField springsIndices1="0 1 2 3" springsIndices2="4 5 6 7" lengths="1 1 0.9 1.1" stiffness="100"/>
//     <FixedProjectiveConstraint indices="0 1 2 3"/>
//     <RigidPlateForceField plate="@../plate/dofs" normal="0 -1 0" indices="4 5 6 7" stiffness="1000"/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include "framework/mechanics/node_group_field.h"
#include "framework/mechanics/node_indices.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class RigidPlateForceField final : public NodeGroupField<2, PairTangent> {
 public:
  void declare(DataTable& table) override {
    ForceField::declare(table);
    table.addLink("plate", plate_).help("state of the plate's node").required();
    table.add("plateNode", plate_node_).help("node of `plate` that the face moves with");
    table.add("normal", normal_).help("direction in which the plate presses, from it to the body").unit("-").required();
    table.add("offset", offset_)
        .recompiled()
        .help("distance of the face from the plate's node, along normal")
        .unit("m");
    table.add("indices", indices_).help("nodes in contact with the plate; every node by default");
    table.add("stiffness", stiffness_constant_)
        .recompiled()
        .help("force on a node over its depth behind the face")
        .unit("N/m")
        .min(0, false)
        .physical();
    table.add("bilateral", bilateral_).help("nodes are glued to the face along the normal");
  }

  void init() override {
    ForceField::init();
    if (!plate_.get()) throw ComponentError("plate names no state", "the state of the plate's node, plate=\"@...\"");
    checkNode(plate_node_, 0, *plate_.get(), "plateNode");
    const double length = normal_.norm();
    if (!(length > 0) || !std::isfinite(length))
      throw ComponentError("normal has no direction", "a vector that is not zero");
    unit_normal_ = normal_ / length;
    nodes_ = data().find("indices")->isSet() ? checkedNodes(indices_, state(), "indices") : allNodes(state());
    if (plate_.get() == &state()) std::erase(nodes_, Index(plate_node_));
  }

  std::vector<State*> states() const override {
    if (plate_.get() == &state()) return {&state()};
    return {&state(), plate_.get()};
  }
  ForceTraits traits() const override {
    ForceTraits traits;
    traits.symmetric = traits.conservative = traits.exact_tangent = true;
    traits.linear = traits.constant_stiffness = bilateral_;
    return traits;
  }
  void compile() override {
    std::vector<Group> rows;
    for (const Index node : nodes_)
      rows.push_back({state().firstRow() + node, plate_.get()->firstRow() + Index(plate_node_)});
    setGroups(std::move(rows), false);
  }

  double energy(ConstRows x) const override {
    double sum = 0;
    for (const Group& row : rows_)
      if (const double g = depth(x, row); g > 0 || bilateral_) sum += stiffness_constant_ / 2 * g * g;
    return sum;
  }
  void addForce(ConstRows x, ConstRows, Rows f) override {
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const double g = depth(x, rows_[i]);
      stiffness_[i].setZero();
      if (!(g > 0) && !bilateral_) continue;
      const Vec3 force = stiffness_constant_ * g * unit_normal_;
      f[rows_[i][0]] += force;
      f[rows_[i][1]] -= force;
      stiffness_[i].k = -stiffness_constant_ * unit_normal_ * unit_normal_.transpose();
    }
  }

 private:
  double depth(ConstRows x, const Group& row) const { return unit_normal_.dot(x[row[1]] - x[row[0]]) + offset_; }

  Link<State> plate_{"mechanical state"};
  int plate_node_ = 0;
  Vec3 normal_ = Vec3::Zero(), unit_normal_ = Vec3::Zero();
  double offset_ = 0, stiffness_constant_ = 500;
  std::vector<int> indices_;
  bool bilateral_ = false;
  std::vector<Index> nodes_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(rigid_plate_force_field) {
  factory.add<stroma::RigidPlateForceField>("RigidPlateForceField",
                                            "a rigid plate that presses on nodes and is pressed back");
}
