// SPDX-License-Identifier: LGPL-2.1-or-later
// CableConstraint: a cable through points of a body, which is pulled at pullPoint. It slides through the points without
// friction, so that one tension T acts along all of it.
//
//   L(x) = |x_1 - pullPoint| + sum |x_i+1 - x_i|
//   valueType displacement: L = L_0 - value, and T is what that takes, not below zero where minForce="0" is given
//   valueType force:        T = value
//
// T and the displacement L_0 - L are `force` and `displacement`. Neither depends on the time step: T is a force, and the
// condition holds at the end of every step. Without pullPoint (hasPullPoint off) the cable ends at its first point.
//
// Source: the names and attributes are those of SOFA's plugin SoftRobots.
//
// Example:
// <Node name="root" dt="0.01">
//   <EulerImplicitSolver/>
//   <SparseLDLSolver/>
//   <MechanicalObject position="0 0 0  1 0 0  2 0 0"/>
//   <UniformMass totalMass="3"/>
//   <RestShapeSpringsForceField stiffness="100"/>
//   <CableConstraint indices="1 2" pullPoint="-1 0 0" valueType="displacement" value="0.1"/>
// </Node>
#include <fmt/format.h>

#include <cmath>

#include "components/lagrangian/pair_constraint.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"

namespace stroma::lagrangian {
namespace {

class Cable final : public PairConstraint {
 public:
  void declare(DataTable& table) override {
    PairConstraint::declare(table);
    table.add("indices", nodes_).required().help("points that the cable runs through, from its pulled end on");
    table.add("pullPoint", pull_).help("where it is pulled").unit("m");
    table.add("hasPullPoint", has_pull_).help("false: it ends at the first of indices");
    table.add("value", values_).atOnce().help("displacement [m] or force [N]; of several the one of valueIndex");
    table.add("valueIndex", index_).help("which of value").min(0);
    table.add("valueType", type_).help("displacement: value is what has been pulled out; force: its tension");
    table.add("minForce", least_).help("0, where it is given: with displacement the cable does not push").unit("N");
    table.add("force", tension_).help("tension of the last step").unit("N").output();
    table.add("displacement", displacement_).help("what has been pulled out after the last step").unit("m").output();
    table.add("cableInitialLength", start_length_).help("length at the start").unit("m").output();
    table.add("cableLength", length_).help("length after the last step").unit("m").output();
    for (const char* name : {"drawPullPoint", "drawPoints", "color"}) table.addVisualOnly(name);
  }
  void init() override {
    PairConstraint::init();
    for (const Index node : nodes_) checkNode(first(), node, "indices");
    if (type_ != "displacement" && type_ != "force")
      throw ComponentError(fmt::format("valueType is {}", type_), "displacement or force");
    if (nodes_.empty() || (nodes_.size() == 1 && !has_pull_))
      throw ComponentError("the cable has no length", "two points, or one and a pullPoint");
    pushes_ = !data().find("minForce")->isSet();
    if (least_ != 0)
      throw ComponentError(fmt::format("minForce is {:g}: no other least tension than zero is held", least_), "0, or no minForce");
    is_measured_ = false;
  }
  void constrainedStepBegins(ConstRows x, double) override {
    if (is_measured_) return;
    start_length_ = length_ = lengthAt(x);
    is_measured_ = true;
  }
  void addConditions(ConstRows x, ConstRows, LagrangianRows& rows) const override {
    const double value = index_ < int(values_.size()) ? values_[std::size_t(index_)] : 0;
    length_ = lengthAt(x);
    // pulling shortens: the force of the row acts along -dL/dx
    const double off = start_length_ - value - length_;
    if (type_ == "force")
      rows.begin(Kind::given, off, value);
    else
      rows.begin(pushes_ ? Kind::equal : Kind::push, off, 0);
    Vec3 before = has_pull_ ? pull_ : Vec3(x[rowOf(first(), nodes_.front())]);
    Index row_before = has_pull_ ? -1 : rowOf(first(), nodes_.front());
    for (std::size_t i = has_pull_ ? 0 : 1; i < nodes_.size(); ++i) {
      const Index row = rowOf(first(), nodes_[i]);
      const Vec3 way = Vec3(x[row]) - before;
      const double length = way.norm();
      const Vec3 n = length > 0 ? Vec3(way / length) : Vec3(Vec3::Zero());
      rows.add(row, -n);
      if (row_before >= 0) rows.add(row_before, n);
      before = x[row], row_before = row;
    }
  }
  void takeForces(std::span<const double> forces) override {
    PairConstraint::takeForces(forces);
    tension_ = forces.empty() ? 0 : forces[0];
    displacement_ = start_length_ - length_;
  }
  void reset() override {
    PairConstraint::reset();
    is_measured_ = false;
  }
  void serialize(Archive& archive) override {
    archive.value("start_length", start_length_);
    archive.value("is_measured", is_measured_);
  }

 private:
  double lengthAt(ConstRows x) const {
    double sum = has_pull_ ? (Vec3(x[rowOf(first(), nodes_.front())]) - pull_).norm() : 0;
    for (std::size_t i = 1; i < nodes_.size(); ++i)
      sum += (Vec3(x[rowOf(first(), nodes_[i])]) - Vec3(x[rowOf(first(), nodes_[i - 1])])).norm();
    return sum;
  }

  std::vector<Index> nodes_;
  Vec3 pull_ = Vec3::Zero();
  bool has_pull_ = true, is_measured_ = false;
  std::vector<double> values_{0};
  int index_ = 0;
  std::string type_ = "displacement";
  double least_ = 0;
  bool pushes_ = true;
  double tension_ = 0, displacement_ = 0, start_length_ = 0;
  mutable double length_ = 0;
};

}  // namespace
}  // namespace stroma::lagrangian

STROMA_COMPONENT(cable_constraint) {
  factory.add<stroma::lagrangian::Cable>("CableConstraint", "a cable that is pulled, by a length or a force");
}
