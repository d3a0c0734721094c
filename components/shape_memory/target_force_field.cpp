// SPDX-License-Identifier: LGPL-2.1-or-later
// TargetForceField: linear actuator forces to places that are given, fixed or moving.
//
//   F_i = k (T_i(t) - P_i),   T_i(t) = target_i + s(t) displacement,   E = k/2 sum |T_i - P_i|^2
//
// `targets` are one place for each listed node; without them the place is where the node is at rest. All targets move
// by `displacement`, times a factor that changes over time (times, factors, period); without factors they stand still
// at target + displacement. t is the end of the step.
//
// Source: M. Nesme et al. 2005, section 4 (LAF, linear actuator force: P_target can depend on geometry or on
// constraints and can change).
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-8"/>
//   <MechanicalObject position="0 0 0  1 0 0  2 0 0"/>
//   <UniformMass totalMass="3"/>
//   <TargetForceField indices="0 2" stiffness="100" displacement="0 0 0.5" times="0 1 2" factors="0 1 0" period="2"/>
// </Node>
#include <fmt/format.h>

#include "framework/mechanics/factor_over_time.h"
#include "framework/mechanics/force_field.h"
#include "framework/mechanics/node_indices.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class TargetForceField final : public ForceField {
 public:
  void declare(DataTable& table) override {
    ForceField::declare(table);
    table.add("indices", indices_).required().help("nodes that are drawn to their targets");
    table.add("targets", targets_).unit("m").help("a place for each index; the node's rest position by default");
    table.add("displacement", displacement_).unit("m").help("added to every target, times the factor");
    table.add("stiffness", stiffness_).alias("kElas").unit("N/m").min(0).physical().help("elastic modulus k");
    factor_.declare(table, "the displacement", FactorOverTime::Sign::any);
  }

  void init() override {
    ForceField::init();
    factor_.check();
    if (indices_.empty()) checkedNodes(indices_, state(), "indices");
    for (std::size_t i = 0; i < indices_.size(); ++i) checkNode(indices_[i], i, state(), "indices");
    if (!data().find("targets")->isSet()) {
      targets_.clear();
      for (const int node : indices_) targets_.push_back(state().rest_position[node]);
    }
    if (targets_.size() != indices_.size())
      throw ComponentError(fmt::format("targets has {} places for {} nodes", targets_.size(), indices_.size()),
                           "as many as indices");
  }
  ForceTraits traits() const override {
    ForceTraits traits;
    traits.linear = traits.constant_stiffness = traits.symmetric = traits.conservative = traits.exact_tangent = true;
    traits.time_dependent = factor_.varies();
    return traits;
  }
  void compile() override { setTime(0); }
  void setTime(double t) override { moved_ = factor_.at(t) * displacement_; }

  double energy(ConstRows x) const override {
    double sum = 0;
    for (std::size_t i = 0; i < indices_.size(); ++i) sum += stiffness_ / 2 * missing(x, i).squaredNorm();
    return sum;
  }
  void addForce(ConstRows x, ConstRows, Rows f) override {
    for (std::size_t i = 0; i < indices_.size(); ++i) f[row(i)] += stiffness_ * missing(x, i);
  }
  void addStiffnessProduct(ConstRows dx, double factor, Rows df) const override {
    for (std::size_t i = 0; i < indices_.size(); ++i) df[row(i)] -= factor * stiffness_ * dx[row(i)];
  }
  void addPattern(BlockPattern&) const override {}  // every diagonal block is in it
  void addStiffness(double factor, BlockMatrix& matrix) const override {
    for (std::size_t i = 0; i < indices_.size(); ++i)
      matrix.add(matrix.diagonal()[row(i)], -factor * stiffness_ * Mat3::Identity());
  }
  void addStiffnessDiagonal(double factor, std::vector<double>& blocks) const override {
    for (std::size_t i = 0; i < indices_.size(); ++i)
      for (std::size_t c = 0; c < 3; ++c) blocks[std::size_t(row(i)) * 9 + 4 * c] -= factor * stiffness_;
  }
  Cost cost() const override { return {2. * double(indices_.size()), 2. * double(indices_.size())}; }

 private:
  Index row(std::size_t i) const { return state().firstRow() + indices_[i]; }
  Vec3 missing(ConstRows x, std::size_t i) const { return targets_[i] + moved_ - x[row(i)]; }

  std::vector<int> indices_;
  std::vector<Vec3> targets_;
  Vec3 displacement_ = Vec3::Zero(), moved_ = Vec3::Zero();
  double stiffness_ = 1;
  FactorOverTime factor_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(target_force_field) {
  factory.add<stroma::TargetForceField>("TargetForceField", "Linear actuator forces to given places, fixed or moving");
}
