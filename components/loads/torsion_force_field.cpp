// SPDX-License-Identifier: LGPL-2.1-or-later
// TorsionForceField: forces that turn nodes about an axis, and grow with the distance from it.
//
//   f_i = tau u x (x_i - o),   u = axis/|axis|,   o = origin,   tau = torque
//
// The moment of each about the axis is tau times the square of its distance. On a rigid frame the same force acts at its
// centre, and besides the torque tau u on its orientation.
//
// The forces follow the nodes and have no potential: they are not part of the energy, and an unsupported node spirals outward.
// Their derivative tau [u] is skew: it has no symmetric part, and an implicit step uses the forces at the evaluated shape.
//
// Source: the name and attributes are SOFA's, which takes tau (I - u u^T) for the derivative: tangent="transverse".
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-10"/>
//   <MechanicalObject position="1 0 0  0 1 0  0 0 1"/>
//   <UniformMass totalMass="0.3"/>
//   <RestShapeSpringsForceField stiffness="100"/>
//   <TorsionForceField indices="0 1 2" torque="5" axis="0 0 2" origin="0.1 0 0"/>
// </Node>
#include <Eigen/Geometry>
#include <cmath>

#include "framework/mechanics/node_group_field.h"
#include "framework/mechanics/node_indices.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class TorsionForceField final : public NodeGroupField<1> {
 public:
  void declare(DataTable& table) override {
    ForceField::declare(table);
    table.add("indices", indices_).help("nodes that are turned").required();
    table.add("torque", torque_)
        .recompiled()
        .help("force over the distance from the axis; of frames also a torque")
        .unit("N/m")
        .required();
    table.add("axis", axis_).recompiled().help("direction of the axis").unit("-").required();
    table.add("origin", origin_).recompiled().help("a point of the axis").unit("m");
    table.addChoice("tangent", tangent_, {"none", "transverse"}).help("none, or SOFA's approximation of the derivative");
  }

  void init() override {
    ForceField::init();
    nodes_ = checkedNodesInOrder(indices_, state(), "indices");
    if (!state().hasFrames() && !state().hasPointsOnly())
      throw ComponentError("the nodes of " + state().path() + " have no place", "points or rigid frames");
    const double length = axis_.norm();
    if (!(length > 0) || !std::isfinite(length)) throw ComponentError("axis has no direction", "a vector that is not zero");
    direction_ = axis_ / length;
    if (torque_ == 0) warn("the torque is zero: the component has no effect");
  }

  ForceTraits traits() const override {
    ForceTraits traits;
    traits.symmetric = true;
    traits.has_stiffness = tangent_ == Tangent::transverse;
    return traits;
  }
  void compile() override {
    setNodes(nodes_, false);
    if (tangent_ == Tangent::none) return;
    for (auto& tangent : stiffness_) tangent.blocks[0] = torque_ * (Mat3::Identity() - direction_ * direction_.transpose());
  }

  double energy(ConstRows) const override { return 0; }
  void addForce(ConstRows x, ConstRows, Rows f) override {
    for (const Group& row : rows_) {
      f[row[0]] += torque_ * direction_.cross(Vec3(x[row[0]]) - origin_);
      if (state().hasFrames()) f[row[0] + 1] += torque_ * direction_;
    }
  }

 protected:
  bool takesAllRows() const override { return true; }

 private:
  enum class Tangent : int { none, transverse };
  std::vector<int> indices_;
  double torque_ = 0;
  Vec3 axis_ = Vec3::Zero(), origin_ = Vec3::Zero(), direction_ = Vec3::UnitZ();
  Tangent tangent_ = Tangent::none;
  std::vector<Index> nodes_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(torsion_force_field) {
  factory.add<stroma::TorsionForceField>("TorsionForceField", "forces that turn nodes about an axis");
}
