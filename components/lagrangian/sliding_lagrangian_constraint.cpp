// SPDX-License-Identifier: LGPL-2.1-or-later
// SlidingLagrangianConstraint: a point that slides along a line of two points, or along a curve of several, as a suture, a
// needle or a catheter does. The line moves with its body, which feels the force.
//
// With the piece from a to b that was nearest where the step started, u its direction and t the point's share of it:
//   n . (x - (1 - t) a - t b) = 0 for two n across u,
//   u . (x - a) >= 0 at the beginning of the curve, u . (b - x) >= 0 at its end
//
// A point goes over to the next piece at the step after the one in which it has passed the corner.
//
// Source: the names and attributes are SOFA's, but for `curve`.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <SparseLDLSolver/>
//   <MechanicalObject position="0 0 0  1 -1 0  0.2 -0.2 0"/>
//   <UniformMass totalMass="3"/>
//   <FixedProjectiveConstraint indices="0 1"/>
//   <SlidingLagrangianConstraint sliding_point="2" axis_1="0" axis_2="1"/>
// </Node>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "components/lagrangian/pair_constraint.h"
#include "framework/scene/factory.h"

namespace stroma::lagrangian {
namespace {

class Sliding final : public PairConstraint {
 public:
  void declare(DataTable& table) override {
    PairConstraint::declare(table);
    table.add("sliding_point", point_).help("point of object1 that slides");
    table.add("axis_1", axis_1_).help("point of object2 where the line begins");
    table.add("axis_2", axis_2_).help("point of object2 where it ends");
    table.add("curve", curve_).help("points of object2 in order along a curve; axis_1 and axis_2 when not given");
  }
  void init() override {
    PairConstraint::init();
    nodes_ = curve_.empty() ? std::vector<Index>{axis_1_, axis_2_} : curve_;
    if (nodes_.size() < 2) throw ComponentError("curve has one point", "two or more");
    checkNode(first(), point_, "sliding_point");
    for (const Index node : nodes_) checkNode(second(), node, curve_.empty() ? "axis_1 or axis_2" : "curve");
    if (&first() == &second() && std::find(nodes_.begin(), nodes_.end(), point_) != nodes_.end())
      throw ComponentError(fmt::format("sliding_point {} is a point of its own line", point_), "another point");
    for (std::size_t i = 1; i < nodes_.size(); ++i)
      if (nodes_[i] == nodes_[i - 1]) throw ComponentError("a piece of the curve has one point twice", "two points");
  }
  void constrainedStepBegins(ConstRows x, double) override {
    const Vec3 p = x[rowOf(first(), point_)];
    double best = 1e300;
    for (std::size_t i = 0; i + 1 < nodes_.size(); ++i) {
      const Vec3 a = placeOf(x, i), along = placeOf(x, i + 1) - a;
      const double length = along.squaredNorm();
      const double t = length > 0 ? std::clamp((p - a).dot(along) / length, 0.0, 1.0) : 0;
      if (const double d = (p - a - t * along).squaredNorm(); d < best) best = d, piece_ = i;
    }
  }
  void addConditions(ConstRows x, ConstRows, LagrangianRows& rows) const override {
    const Index row = rowOf(first(), point_), a = rowOf(second(), nodes_[piece_]), b = rowOf(second(), nodes_[piece_ + 1]);
    const Vec3 from = Vec3(x[row]) - Vec3(x[a]), along = Vec3(x[b]) - Vec3(x[a]);
    const double length = along.norm();
    const Vec3 u = length > 0 ? Vec3(along / length) : Vec3(Vec3::UnitX());
    const double share = length > 0 ? from.dot(u) / length : 0;
    const Vec3 across = u.unitOrthogonal();
    for (const Vec3& n : {across, Vec3(u.cross(across))}) {
      rows.begin(Kind::equal, n.dot(from));
      rows.add(row, n), rows.add(a, (share - 1) * n), rows.add(b, -share * n);
    }
    if (piece_ == 0) {
      rows.begin(Kind::push, u.dot(from));
      rows.add(row, u), rows.add(a, -u);
    }
    if (piece_ + 2 == nodes_.size()) {
      rows.begin(Kind::push, length - u.dot(from));
      rows.add(row, -u), rows.add(b, u);
    }
  }

 private:
  Vec3 placeOf(ConstRows x, std::size_t i) const { return x[rowOf(second(), nodes_[i])]; }

  Index point_ = 0, axis_1_ = 0, axis_2_ = 0;
  std::vector<Index> curve_, nodes_;
  std::size_t piece_ = 0;  ///< of the present step
};

}  // namespace
}  // namespace stroma::lagrangian

STROMA_COMPONENT(sliding_lagrangian_constraint) {
  factory.add<stroma::lagrangian::Sliding>("SlidingLagrangianConstraint", "a point that slides along a line or a curve");
}
