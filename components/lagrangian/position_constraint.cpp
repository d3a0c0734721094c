// SPDX-License-Identifier: LGPL-2.1-or-later
// PositionConstraint: points or rigid frames that are moved along directions, by a displacement or by a force.
//
//   s = w d . (x - x_0),   for each point and each direction d in use; x_0 where the scene starts, w its weight
//   s = w (d . (c - c_0) + r . log(q q_0^-1)),   of a frame: d and r are the halves of one of six directions
//   valueType displacement: s = value, and f is what that takes, between minForce and maxForce where they are given
//   valueType force:        f = value, while -maxNegativeDisp <= s <= maxPositiveDisp where they are given
//
// The force on a point or a centre is f w d, and the torque f w r where a frame turns about r alone; elsewhere it is that of
// the work f ds. One value and one pair of bounds apply to all points and directions, and each has its own force: `forces` has
// all, `force` and `displacement` are those of the first. They do not depend on the time step. Along r displacements are
// angles [rad] between -pi and pi, and forces are torques [N m]; with directions of both kinds the same bounds are used for
// both.
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
#include <numbers>

#include "components/lagrangian/actuator.h"
#include "framework/mechanics/frames.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"
#include "framework/scene/node.h"

namespace stroma::lagrangian {
namespace {

class Position final : public Actuator {
 public:
  void declare(DataTable& table) override {
    declareOneState(table);
    table.add("indices", nodes_).help("points or frames that are moved");
    table.add("directions", written_)
        .help("three directions; of frames six, each to move along and to turn about, below pi; those of the axes by default")
        .unit("-");
    table.add("useDirections", used_).help("1 for each of the directions to move along, 0 else; all by default");
    table.add("weight", weights_).help("factor on the way along each of the directions, or one for all").unit("-");
    declareValue(table, "displacement", "force", true, "displacement [m] or force [N]");
    table.add("minForce", least_force_).help("least force; without it, none").unit("N");
    table.add("maxForce", most_force_).help("largest force; without it, none").unit("N");
    table.add("maxPositiveDisp", most_way_).help("largest displacement; without it, none").unit("m");
    table.add("maxNegativeDisp", least_way_).help("largest displacement the other way; without it, none").unit("m");
    table.add("force", told_force_).help("force of the last step, on the first point along the first direction").unit("N").output();
    table.add("displacement", way_).help("displacement of that point along it after the last step").unit("m").output();
    table.add("delta", ways_).help("the displacements of all, direction after direction of each point").unit("m").output();
  }
  void init() override {
    Actuator::init();
    if (nodes_.empty()) throw ComponentError("indices names no point", "at least one");
    for (const Index node : nodes_) checkNode(first(), node, "indices");
    findDirections();
    bound({-written("maxNegativeDisp", least_way_, infinity), written("maxPositiveDisp", most_way_, infinity), infinity},
          {written("minForce", least_force_, -infinity), written("maxForce", most_force_, infinity), infinity});
    checkTurns();
    startAt(0);
  }
  void constrainedStepBegins(ConstRows x, double t_end) override {
    checkTurns();
    for (std::size_t i = starts_.size(); i < nodes_.size(); ++i) {
      const Index row = rowOf(first(), nodes_[i]);
      starts_.push_back(x[row]);
      if (first().hasFrames()) turns_.push_back(orientationIn(x, row + 1));
    }
    Actuator::constrainedStepBegins(x, t_end);
  }
  void addConditions(ConstRows x, ConstRows, LagrangianRows& rows) const override {
    ways_.clear();
    for (std::size_t i = 0; i < starts_.size(); ++i) {
      const Index row = rowOf(first(), nodes_[i]);
      const bool turns = first().hasFrames();
      const Vec3 moved = Vec3(x[row]) - starts_[i];
      const Vec3 turned = turns ? rotationVector(orientationIn(x, row + 1) * turns_[i].conjugate()) : Vec3(Vec3::Zero());
      const Mat3 slope = turns ? dexpInverse(turned) : Mat3(Mat3::Zero());
      for (const Direction& each : along_) {
        ways_.push_back(each.moves.dot(moved) + each.turns.dot(turned));
        addPlanned(ways_.back(), rows, [&](double sign) {
          rows.add(row, sign * each.moves);
          if (turns) rows.add(row + 1, sign * (slope.transpose() * each.turns));
        });
      }
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
    starts_.clear(), turns_.clear(), ways_.clear();
    startAt(0);
  }
  void serialize(Archive& archive) override {
    Actuator::serialize(archive);
    archive.list("starts", starts_);
    if (first().hasFrames()) archive.list("turns", turns_);
    archive.list("ways", ways_);
  }

 protected:
  Nodes nodes() const override { return Nodes::points_or_frames; }
  double measure(ConstRows) const override { return 0; }
  void addGradient(ConstRows, double, LagrangianRows&) const override {}

 private:
  /// One of those in use, times its weight.
  struct Direction {
    Vec3 moves, turns;
  };

  /// A turn is found from an orientation, which is the same after a whole one.
  void checkTurns() const {
    if (imposesForce()) return;
    for (const Direction& each : along_)
      if (const double most = std::numbers::pi * each.turns.norm(); each.moves.isZero(0) && largestValue() > most)
        throw ComponentError(fmt::format("value is {:g}, and a frame is found to turn by {:.4g} at most", largestValue(), most),
                             fmt::format("-{0:.4g} to {0:.4g}", most));
  }

  void findDirections() {
    const bool frames = first().hasFrames();
    const std::size_t count = frames ? 6 : 3, each = frames ? 2 : 1;
    const std::string many = frames ? "six" : "three";
    if (!written_.empty() && written_.size() != each * count)
      throw ComponentError(fmt::format("directions has {} numbers", 3 * written_.size()),
                           fmt::format("{} directions of {} numbers", many, 3 * each));
    if (!used_.empty() && used_.size() != count) throw ComponentError(fmt::format("useDirections has {} entries", used_.size()), many);
    if (weights_.size() != count && weights_.size() != 1)
      throw ComponentError(fmt::format("weight has {} numbers", weights_.size()),
                           fmt::format("one, or one for each of the {} directions", many));
    along_.clear();
    for (std::size_t k = 0; k < count; ++k)
      if (used_.empty() || used_[k]) along_.push_back(direction(k, each));
    if (along_.empty()) throw ComponentError("useDirections selects no direction", "a 1 for each direction to move along");
  }
  /// Both halves of that of a frame have the length 1, or none.
  Direction direction(std::size_t k, std::size_t each) const {
    const double weight = weights_.size() == 1 ? weights_[0] : weights_[k];
    Direction found{Vec3::Zero(), Vec3::Zero()};
    if (written_.empty())
      (k < 3 ? found.moves : found.turns)[Index(k % 3)] = weight;
    else {
      found.moves = weight * written_[each * k].normalized();
      if (each > 1) found.turns = weight * written_[each * k + 1].normalized();
    }
    if (!(found.moves.norm() + found.turns.norm() > 0))
      throw ComponentError(fmt::format("entry {} of directions has no length or no weight", k), "both other than zero");
    return found;
  }

  std::vector<Index> nodes_{0};
  std::vector<Vec3> written_;
  std::vector<Direction> along_;
  std::vector<bool> used_;
  std::vector<double> weights_{1};
  double least_force_ = 0, most_force_ = 0, least_way_ = 0, most_way_ = 0;
  std::vector<Vec3> starts_;          ///< x_0 or c_0 of the points [m]
  std::vector<Quaternion> turns_;     ///< q_0 of frames
  mutable std::vector<double> ways_;  ///< s at the x of the last conditions, direction after direction of each point [m]
  std::vector<double> of_rows_;       ///< their forces [N]
};

}  // namespace
}  // namespace stroma::lagrangian

STROMA_COMPONENT(position_constraint) {
  factory.add<stroma::lagrangian::Position>("PositionConstraint", "points or frames that are moved along directions, by a way or a force");
}
