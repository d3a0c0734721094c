// SPDX-License-Identifier: LGPL-2.1-or-later
// LinearForceField: a force on each of some nodes that is given at times and linear between them.
//
//   f_i(t) = forces at t for each of points;  energy = -sum f_i . x_i;  K = 0
//
// Before the first and after the last time the force is constant.
//
// Source: the name, points, times and forces are SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerExplicitSolver/>
//   <MechanicalObject position="0 0 0  1 0 0  2 0 0"/>
//   <UniformMass totalMass="3"/>
//   <LinearForceField points="1 2" times="0 0.5 1" forces="0 0 0  0 -2 0  0 0 1"/>
// </Node>
#include <algorithm>

#include "framework/mechanics/force_field.h"
#include "framework/mechanics/key_times.h"
#include "framework/mechanics/local_load.h"
#include "framework/mechanics/node_indices.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class LinearForceField final : public ForceField, public LocalLoad {
 public:
  void declare(DataTable& table) override {
    ForceField::declare(table);
    table.add("points", points_).alias("indices").help("loaded nodes").required();
    force_.declare(table, "forces", "force on each of points at each of keyTimes", "N");
    table.find("keyTimes")->alias("times");
    for (const char* drawing : {"arrowSizeCoef", "showArrowSize"}) table.addVisualOnly(drawing);
  }

  void init() override {
    ForceField::init();
    nodes_ = checkedNodesInOrder(points_, state(), "points");
    force_.check();
    now_ = force_.at(node().root().root_time);
  }

  ForceTraits traits() const override {
    ForceTraits traits;
    traits.linear = traits.constant_stiffness = traits.symmetric = traits.conservative = traits.exact_tangent = true;
    traits.has_stiffness = false;
    traits.time_dependent = true;
    return traits;
  }
  void setTime(double t) override { now_ = force_.at(t); }
  double energy(ConstRows x) const override {
    double sum = 0;
    for (const Index node : nodes_) sum -= now_.dot(x[state().firstRow() + node]);
    return sum;
  }
  void addForce(ConstRows, ConstRows, Rows f) override {
    for (const Index node : nodes_) f[state().firstRow() + node] += now_;
  }
  void addLoadedRows(std::vector<Index>& rows) const override {
    for (const Index node : nodes_) rows.push_back(state().firstRow() + node);
  }
  // K = 0
  void addStiffnessProduct(ConstRows, double, Rows) const override {}
  void addPattern(BlockPattern&) const override {}
  void addStiffness(double, BlockMatrix&) const override {}
  void addStiffnessDiagonal(double, std::vector<double>&) const override {}

 private:
  std::vector<int> points_;
  KeyTimes<Vec3> force_;
  std::vector<Index> nodes_;
  Vec3 now_ = Vec3::Zero();  ///< [N]
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(linear_force_field) {
  factory.add<stroma::LinearForceField>("LinearForceField", "forces on nodes, given at times and linear between them");
}
