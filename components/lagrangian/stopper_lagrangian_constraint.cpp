// SPDX-License-Identifier: LGPL-2.1-or-later
// StopperLagrangianConstraint: a scalar, such as the angle of a joint, that stays between two bounds.
//
//   x - min >= 0,   max - x >= 0,   force only if one of them is zero
//
// Source: the names and attributes are SOFA's.
//
// Example:
// <Node name="root" dt="0.01">
//   <EulerImplicitSolver/>
//   <SparseLDLSolver/>
//   <MechanicalObject template="Vec1" position="0" velocity="1"/>
//   <UniformMass totalMass="1"/>
//   <StopperLagrangianConstraint index="0" min="-0.5" max="0.5"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>

#include "components/lagrangian/pair_constraint.h"
#include "framework/scene/factory.h"

namespace stroma::lagrangian {
namespace {

class Stopper final : public PairConstraint {
 public:
  void declare(DataTable& table) override {
    declareOneState(table);
    table.add("index", node_).help("the number of the state that is bounded");
    table.add("min", least_).help("least value");
    table.add("max", most_).help("largest value");
    table.add("startsInside", starts_inside_)
        .help("a number that would start beyond starts at its bound, as in SOFA, and is not thrown there");
  }
  void init() override {
    PairConstraint::init();
    checkNode(first(), node_, "index");
    if (!(least_ < most_)) throw ComponentError(fmt::format("min is {:g} and max {:g}", least_, most_), "min below max");
    if (!starts_inside_) return;
    first().ensureReady();
    double& start = first().position[std::size_t(node_)].x();
    start = std::clamp(start, least_, most_);
  }
  void addConditions(ConstRows x, ConstRows, LagrangianRows& rows) const override {
    const Index row = rowOf(first(), node_);
    rows.begin(Kind::push, x[row].x() - least_);
    rows.add(row, Vec3::UnitX());
    rows.begin(Kind::push, most_ - x[row].x());
    rows.add(row, -Vec3::UnitX());
  }

 protected:
  Nodes nodes() const override { return Nodes::values; }

 private:
  Index node_ = 0;
  double least_ = -100, most_ = 100;
  bool starts_inside_ = false;
};

}  // namespace
}  // namespace stroma::lagrangian

STROMA_COMPONENT(stopper_lagrangian_constraint) {
  factory.add<stroma::lagrangian::Stopper>("StopperLagrangianConstraint", "a scalar that stays between two bounds");
}
