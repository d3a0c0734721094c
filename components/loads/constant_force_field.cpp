// SPDX-License-Identifier: LGPL-2.1-or-later
// ConstantForceField: forces on nodes that depend neither on the shape nor on time.
//
//   f_i = forces[i] for each index, or totalForce / (number of indices);  energy = -sum f_i . x_i;  K = 0
//
// One value in `forces` (or `force`) goes to every node; totalForce is shared equally by the nodes, not by area. A node
// listed twice is loaded twice. Without `indices` every node is loaded. With indexFromEnd the index 0 is the last node.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerExplicitSolver/>
//   <MechanicalObject position="0 0 0  1 0 0  2 0 0"/>
//   <UniformMass totalMass="3"/>
//   <ConstantForceField indices="1 2" totalForce="0 -2 0"/>
// </Node>
#include <fmt/format.h>

#include <numeric>

#include "framework/mechanics/force_field.h"
#include "framework/mechanics/node_indices.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class ConstantForceField final : public ForceField {
 public:
  void declare(DataTable& table) override {
    ForceField::declare(table);
    table.add("indices", indices_).help("loaded nodes; every node when not given");
    table.add("forces", forces_).recompiled().help("force on each listed node, or one for all of them").unit("N");
    table.add("force", force_).recompiled().help("the same force on each listed node").unit("N").shorthand();
    table.add("totalForce", total_force_).recompiled().help("force shared equally by the listed nodes").unit("N");
    table.add("indexFromEnd", from_end_).help("count indices from the last node: 0 is the last");
    for (const char* without_effect : {"showArrowSize", "showColor", "topology"}) table.addVisualOnly(without_effect);
  }

  void init() override {
    ForceField::init();
    if (data().find("indices")->isSet()) {
      if (indices_.empty()) checkedNodes(indices_, state(), "indices");
      for (std::size_t i = 0; i < indices_.size(); ++i) checkNode(indices_[i], i, state(), "indices");
      nodes_.assign(indices_.begin(), indices_.end());
    } else {
      inform(fmt::format("no indices: all {} nodes of {} are loaded", state().size(), state().path()));
      nodes_.resize(state().size());
      std::iota(nodes_.begin(), nodes_.end(), 0);
    }
    if (from_end_)
      for (Index& node : nodes_) node = state().size() - 1 - node;
    distribute();
  }

  ForceTraits traits() const override {
    ForceTraits traits;
    traits.linear = traits.constant_stiffness = traits.symmetric = traits.conservative = traits.exact_tangent = true;
    traits.has_stiffness = false;
    return traits;
  }

  double energy(ConstRows x) const override {
    double sum = 0;
    for (std::size_t i = 0; i < nodes_.size(); ++i) sum -= forces_[i].dot(x[state().firstRow() + nodes_[i]]);
    return sum;
  }
  void addForce(ConstRows, ConstRows, Rows f) override {
    for (std::size_t i = 0; i < nodes_.size(); ++i) f[state().firstRow() + nodes_[i]] += forces_[i];
  }
  // K = 0
  void addStiffnessProduct(ConstRows, double, Rows) const override {}
  void addPattern(BlockPattern&) const override {}
  void addStiffness(double, BlockMatrix&) const override {}
  void addStiffnessDiagonal(double, std::vector<double>&) const override {}

 private:
  void distribute() {
    int given = 0;
    for (const char* name : {"forces", "force", "totalForce"}) given += data().find(name)->isSet();
    if (given != 1)
      throw ComponentError(given == 0 ? "there is no force" : "more than one of forces, force and totalForce is given",
                           "forces (one per node or one for all) or totalForce");
    if (data().find("totalForce")->isSet()) forces_ = {total_force_ / double(nodes_.size())};
    if (data().find("force")->isSet()) forces_ = {force_};
    if (forces_.size() == 1) forces_.resize(nodes_.size(), Vec3(forces_[0]));
    if (forces_.size() != nodes_.size())
      throw ComponentError(fmt::format("forces has {} values for {} nodes", forces_.size(), nodes_.size()),
                           fmt::format("1 value or {}", nodes_.size()));
    for (const Vec3& force : forces_)
      if (!force.allFinite()) throw ComponentError("a force is not finite", "finite numbers");
    total_force_.setZero();
    for (const Vec3& force : forces_) total_force_ += force;
  }

  std::vector<int> indices_;
  std::vector<Vec3> forces_;
  Vec3 force_ = Vec3::Zero(), total_force_ = Vec3::Zero();
  bool from_end_ = false;
  std::vector<Index> nodes_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(constant_force_field) {
  factory.add<stroma::ConstantForceField>("ConstantForceField", "Given forces on nodes");
}
