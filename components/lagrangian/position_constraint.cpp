// SPDX-License-Identifier: LGPL-2.1-or-later
// PositionConstraint: points that are moved along directions, by a way or by a force.
//
//   s = w d . (x - x_0),   for each point and each direction d in use; x_0 where the scene starts, w its weight
//   valueType displacement: s = value, and f is what that takes, between minForce and maxForce where they are given
//   valueType force:        f = value, while -maxNegativeDisp <= s <= maxPositiveDisp where they are given
//
// The force on a point is f w d. One value and one pair of bounds stand for all points and directions, and each has a force of
// its own: `forces` has all, `force` and `displacement` are those of the first. They do not depend on the time step.
//
// Source: the names and attributes are those of SOFA's plugin SoftRobots, where forces are f times the time step.
//
// Example:
// <Node name="root" dt="0.01">
//   <EulerImplicitSolver/>
//   <SparseLDLSolver/>
//   <MechanicalObject position="0 0 0  1 0 0"/>
//   <UniformMass totalMass="2"/>
//   <RestShapeSpringsForceField stiffness="100"/>
//   <PositionConstraint indices="1" useDirections="0 1 0" valueType="displacement" value="0.1"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>

#include "components/lagrangian/actuator.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"
#include "framework/scene/node.h"

namespace stroma::lagrangian {
namespace {

class Position final : public Actuator {
 public:
  void declare(DataTable& table) override {
    declareOneState(table);
    table.add("indices", nodes_).help("points that are moved");
    table.add("directions", written_).help("three directions; those of the axes when not given").unit("-");
    table.add("useDirections", used_).help("1 for each of the three directions to move along, 0 else");
    table.add("weight", weights_).help("factor on the way along each of the three directions, or one for all").unit("-");
    declareValue(table, "displacement", "force", true, "displacement [m] or force [N]");
    table.add("minForce", least_force_).help("least force; without it, none").unit("N");
    table.add("maxForce", most_force_).help("largest force; without it, none").unit("N");
    table.add("maxPositiveDisp", most_way_).help("largest displacement; without it, none").unit("m");
    table.add("maxNegativeDisp", least_way_).help("largest displacement the other way; without it, none").unit("m");
    table.add("force", told_force_).help("force of the last step, on the first point along the first direction").unit("N").output();
    table.add("displacement", way_).help("what that point has moved along it after the last step").unit("m").output();
  }
  void init() override {
    Actuator::init();
    if (nodes_.empty()) throw ComponentError("indices names no point", "at least one");
    for (const Index node : nodes_) checkNode(first(), node, "indices");
    findDirections();
    bound({-written("maxNegativeDisp", least_way_, infinity), written("maxPositiveDisp", most_way_, infinity), infinity},
          {written("minForce", least_force_, -infinity), written("maxForce", most_force_, infinity), infinity});
    startAt(0);
  }
  void constrainedStepBegins(ConstRows x, double t_end) override {
    if (starts_.empty())
      for (const Index node : nodes_) starts_.push_back(x[rowOf(first(), node)]);
    Actuator::constrainedStepBegins(x, t_end);
  }
  void addConditions(ConstRows x, ConstRows, LagrangianRows& rows) const override {
    ways_.clear();
    for (std::size_t i = 0; i < starts_.size(); ++i)
      for (const Vec3& along : along_) {
        const Index row = rowOf(first(), nodes_[i]);
        ways_.push_back(along.dot(Vec3(x[row]) - starts_[i]));
        addPlanned(ways_.back(), rows, [&](double sign) { rows.add(row, sign * along); });
      }
  }
  void takeForces(std::span<const double> forces) override {
    const std::size_t each = planned();
    of_rows_.clear();
    for (std::size_t i = 0; i < ways_.size(); ++i) of_rows_.push_back(plannedForce(forces.subspan(i * each, each)));
    const bool any = !ways_.empty();
    tell(any ? of_rows_[0] : 0, any ? ways_[0] : 0, of_rows_);
  }
  void reset() override {
    Actuator::reset();
    starts_.clear();
    startAt(0);
  }
  void serialize(Archive& archive) override {
    Actuator::serialize(archive);
    archive.list("starts", starts_);
  }

 protected:
  double measure(ConstRows) const override { return 0; }
  void addGradient(ConstRows, double, LagrangianRows&) const override {}

 private:
  void findDirections() {
    const std::vector<Vec3> axes{Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
    const std::vector<Vec3>& all = written_.empty() ? axes : written_;
    if (all.size() != 3) throw ComponentError(fmt::format("there are {} directions", all.size()), "three");
    if (used_.size() != 3)
      throw ComponentError(fmt::format("useDirections has {} entries", used_.size()), "three; frames are moved by their centres only");
    if (weights_.size() != 3 && weights_.size() != 1)
      throw ComponentError(fmt::format("weight has {} numbers", weights_.size()), "one, or one for each of the three directions");
    along_.clear();
    for (std::size_t k = 0; k < 3; ++k) {
      if (!used_[k]) continue;
      const double weight = weights_.size() == 1 ? weights_[0] : weights_[k];
      if (!(all[k].norm() > 0) || !(std::abs(weight) > 0))
        throw ComponentError(fmt::format("entry {} of directions has no length or no weight", k), "both other than zero");
      along_.push_back(weight * all[k].normalized());
    }
    if (along_.empty()) throw ComponentError("useDirections holds no direction", "a 1 for each direction to move along");
  }

  std::vector<Index> nodes_{0};
  std::vector<Vec3> written_, along_;  ///< directions; those in use, times their weights
  std::vector<bool> used_{true, true, true};
  std::vector<double> weights_{1};
  double least_force_ = 0, most_force_ = 0, least_way_ = 0, most_way_ = 0;
  std::vector<Vec3> starts_;          ///< x_0 of the points [m]
  mutable std::vector<double> ways_;  ///< s at the x of the last conditions, direction after direction of each point [m]
  std::vector<double> of_rows_;       ///< their forces [N]
};

}  // namespace
}  // namespace stroma::lagrangian

STROMA_COMPONENT(position_constraint) {
  factory.add<stroma::lagrangian::Position>("PositionConstraint", "points that are moved along directions, by a way or a force");
}
