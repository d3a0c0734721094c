// SPDX-License-Identifier: LGPL-2.1-or-later
// SlidingLagrangianConstraint: a point that slides along a line of two points, or along a curve of several, as a suture, a
// needle or a catheter does. The line moves with its body, which feels the force at the very point. Nothing rubs.
//
// On the piece from a to b, u its direction and t the point's share of it:
//   n . (x - (1 - t) a - t b) = 0 for two n across u,
//   u . (x - a) >= 0,  u . (b - x) >= 0
// so that the point is on the piece where a step ends. The force F on it is across u, or at a corner what holds it there.
//
// Where the way goes on behind an end, to a piece of direction w away from it, the point goes over in the same step if F, found
// at the end, does not hold it from there: F . w < 0. Else the corner is a valley of what pulls the point, and it stays. This goes
// down the way until it rests: for a linear body it is the nearest minimum of the step's energy on the curve. What goes over a
// corner keeps the part of its momentum along the next piece. A curve whose last point is its first goes round.
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
#include "framework/mechanics/changes_conditions.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"

namespace stroma::lagrangian {
namespace {

class Sliding final : public PairConstraint, public ChangesConditions {
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
    // at a crossing it stays on its piece
    constexpr double as_near = 1e-6;
    double best = std::max(0.0, distanceTo(x, p, piece_) - as_near * (placeOf(x, piece_ + 1) - placeOf(x, piece_)).norm());
    for (std::size_t i = 0; i < pieces(); ++i)
      if (const double d = distanceTo(x, p, i); d < best) best = d, piece_ = i;
    across_ = directionOf(x, piece_).unitOrthogonal();
    turns_left_ = most_turns, sense_ = 0;
  }
  void addConditions(ConstRows x, ConstRows, LagrangianRows& rows) const override {
    const Index row = rowOf(first(), point_), a = rowOf(second(), nodes_[piece_]), b = rowOf(second(), nodes_[piece_ + 1]);
    const Vec3 from = Vec3(x[row]) - Vec3(x[a]), u = directionOf(x, piece_);
    const double length = (Vec3(x[b]) - Vec3(x[a])).norm(), along = u.dot(from), share = length > 0 ? along / length : 0;
    const Vec3 across = acrossOf(u);
    for (const Vec3& n : {across, Vec3(u.cross(across))}) {
      rows.begin(Kind::equal, n.dot(from));
      rows.add(row, n), rows.add(a, (share - 1) * n), rows.add(b, -share * n);
    }
    // an end that is far takes no force, and costs no solve
    constexpr double near = 0.1;
    rows.begin(along < near * length ? Kind::push : Kind::given, along);
    rows.add(row, u), rows.add(a, -u);
    rows.begin(length - along < near * length ? Kind::push : Kind::given, length - along);
    rows.add(row, -u), rows.add(b, u);
  }
  bool changeConditions(ConstRows x, std::span<const double> forces, std::span<const double>) override {
    const int sense = forces[3] > 0 ? 1 : forces[2] > 0 ? -1 : 0;
    if (sense == 0 || (sense != sense_ && turns_left_ == 0)) return false;
    const bool is_last = sense > 0 ? piece_ + 1 == pieces() : piece_ == 0;
    if (is_last && nodes_.front() != nodes_.back()) return false;
    const std::size_t next = (piece_ + pieces() + std::size_t(sense)) % pieces();
    const Vec3 u = directionOf(x, piece_), across = acrossOf(u);
    const Vec3 force = forces[0] * across + forces[1] * u.cross(across) + (forces[2] - forces[3]) * u;
    constexpr double rounding = 1e-12;
    if (!(sense * force.dot(directionOf(x, next)) < -rounding * force.norm())) return false;
    if (sense != sense_) --turns_left_;
    piece_ = next, sense_ = sense;
    return true;
  }
  void serialize(Archive& archive) override {
    PairConstraint::serialize(archive);
    archive.value("piece", piece_);
  }

 private:
  static constexpr int most_turns = 4;  ///< in a step, of the sense in which it goes over corners

  std::size_t pieces() const { return nodes_.size() - 1; }
  Vec3 placeOf(ConstRows x, std::size_t i) const { return x[rowOf(second(), nodes_[i])]; }
  Vec3 directionOf(ConstRows x, std::size_t piece) const {
    const Vec3 way = placeOf(x, piece + 1) - placeOf(x, piece);
    const double length = way.norm();
    return length > 0 ? Vec3(way / length) : Vec3(Vec3::UnitX());
  }
  double distanceTo(ConstRows x, const Vec3& p, std::size_t piece) const {
    const Vec3 a = placeOf(x, piece), way = placeOf(x, piece + 1) - a;
    const double square = way.squaredNorm(), t = square > 0 ? std::clamp((p - a).dot(way) / square, 0.0, 1.0) : 0;
    return (p - a - t * way).norm();
  }
  /// Turns with u smoothly in a step: a rule that weighs forces where it starts takes the same l along both.
  Vec3 acrossOf(const Vec3& u) const {
    constexpr double least = 0.1;
    const Vec3 n = across_ - across_.dot(u) * u;
    return n.norm() > least ? Vec3(n.normalized()) : Vec3(u.unitOrthogonal());
  }

  Index point_ = 0, axis_1_ = 0, axis_2_ = 0;
  std::vector<Index> curve_, nodes_;
  std::size_t piece_ = 0;  ///< where the point is
  Vec3 across_ = Vec3::Zero();  ///< across the piece where the step starts
  int turns_left_ = most_turns, sense_ = 0;  ///< in the step; the sense: 1 goes on, -1 goes back
};

}  // namespace
}  // namespace stroma::lagrangian

STROMA_COMPONENT(sliding_lagrangian_constraint) {
  factory.add<stroma::lagrangian::Sliding>("SlidingLagrangianConstraint", "a point that slides along a line or a curve");
}
