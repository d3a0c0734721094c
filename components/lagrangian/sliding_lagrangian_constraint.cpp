// SPDX-License-Identifier: LGPL-2.1-or-later
// SlidingLagrangianConstraint: a point that slides along a line of two points, or along a curve of several, as a suture, a
// needle or a catheter does. The line moves with its body, and the force acts on it exactly at the point. There is no
// friction.
//
// On the piece from a to b, u its direction and t the point's share of it:
//   n . (x - (1 - t) a - t b) = 0 for two n across u,
//   u . (x - a) >= 0,  u . (b - x) >= 0
// so that the point is on the piece at the end of a step. The force F on it is normal to u, or at a corner the force that
// holds it there.
//
// If the curve continues beyond an end, with a piece of direction w away from it, the point moves on in the same step if F,
// found at the end, does not hold it back: F . w < 0. Otherwise the corner is a minimum of the energy, and the point stays. It
// moves on over any number of pieces until it stops: for a linear body at the nearest minimum of the step's energy on the
// curve. Pieces of zero length are skipped. At a corner dissipative rules keep the component of the momentum along the next
// piece. TrapezoidalRuleSolver keeps the speed of a free point, and of points tied to it at its position, up to 120 degrees
// (integrators/multipliers.h). A curve whose last point is its first is closed.
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
#include <limits>

#include "components/lagrangian/pair_constraint.h"
#include "framework/mechanics/condition_roles.h"
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
    table.add("curve", curve_).help("points of object2 in order along a curve; axis_1 and axis_2 by default");
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
    double whole = 0;
    for (std::size_t i = 0; i < pieces(); ++i) whole += wayOf(x, i).norm();
    if (!(whole > 0))
      throw ComponentError(fmt::format("{}: {}: all points of its curve are at one place", where().text(), path()),
                           "points that lie apart");
    no_length_ = 1e-12 * whole;
    // at a crossing it stays on its piece
    constexpr double as_near = 1e-6;
    double best = hasLength(x, piece_) ? std::max(0.0, distanceTo(x, p, piece_) - as_near * wayOf(x, piece_).norm())
                                       : std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < pieces(); ++i)
      if (const double d = distanceTo(x, p, i); d < best && hasLength(x, i)) best = d, piece_ = i;
    across_ = directionOf(x, piece_).unitOrthogonal();
    sense_ = 0, most_at_once_ = pieces();
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
  /// As far along the curve as a point would go whose place without the force here is p - answer F: down to the first minimum of
  /// the distance to there. Of a point on a curve that is held this is the step's rest, else the next search begins there. After a
  /// turn it goes half as far at once at most, so that a curve that gives way does not send it to and fro.
  bool changeConditions(ConstRows x, std::span<const double> forces, std::span<const double> answers) override {
    const Vec3 p = x[rowOf(first(), point_)], u = directionOf(x, piece_), across = acrossOf(u);
    const Vec3 force = forces[0] * across + forces[1] * u.cross(across) + (forces[2] - forces[3]) * u;
    for (const int sense : {1, -1}) {
      const std::size_t end = sense > 0 ? 3 : 2;
      if (!(forces[end] > 0) && hasLength(x, piece_)) continue;
      const double answer = answers[end] > 0 ? answers[end] : std::max(answers[0], answers[1]);
      const std::size_t most = sense_ == -sense ? std::max<std::size_t>(1, most_at_once_ / 2) : most_at_once_;
      const std::size_t to = walk(x, p - answer * force, sense, most);
      if (to == piece_) continue;
      sense_ = sense, piece_ = to, most_at_once_ = most;
      return true;
    }
    return false;
  }
  void reset() override {
    PairConstraint::reset();
    piece_ = 0;
  }
  void serialize(Archive& archive) override {
    PairConstraint::serialize(archive);
    archive.value("piece", piece_);
  }

 private:
  std::size_t pieces() const { return nodes_.size() - 1; }
  Vec3 placeOf(ConstRows x, std::size_t i) const { return x[rowOf(second(), nodes_[i])]; }
  Vec3 wayOf(ConstRows x, std::size_t piece) const { return placeOf(x, piece + 1) - placeOf(x, piece); }
  /// Else its direction is round-off, and it is stepped over.
  bool hasLength(ConstRows x, std::size_t piece) const { return wayOf(x, piece).norm() > no_length_; }
  Vec3 directionOf(ConstRows x, std::size_t piece) const {
    const Vec3 way = wayOf(x, piece);
    const double length = way.norm();
    return length > 0 ? Vec3(way / length) : Vec3(Vec3::UnitX());
  }
  /// The piece that a point is led to from its present one's end by what draws it to `aim`, `most` pieces on at most.
  std::size_t walk(ConstRows x, const Vec3& aim, int sense, std::size_t most) const {
    constexpr double rounding = 1e-12;
    std::size_t to = piece_, at = piece_;
    for (std::size_t gone = 0, passed = 0; gone < most && passed < pieces(); ++passed) {
      const bool is_last = sense > 0 ? at + 1 == pieces() : at == 0;
      if (is_last && nodes_.front() != nodes_.back()) break;
      at = (at + pieces() + std::size_t(sense)) % pieces();
      if (!hasLength(x, at)) continue;
      const Vec3 from = placeOf(x, sense > 0 ? at : at + 1), way = sense * wayOf(x, at);
      const double length = way.norm(), along = (aim - from).dot(way) / length;
      if (!(along > rounding * (from.norm() + (aim - from).norm() + length))) break;
      to = at, ++gone;
      if (along <= length) break;
    }
    return to;
  }
  double distanceTo(ConstRows x, const Vec3& p, std::size_t piece) const {
    const Vec3 a = placeOf(x, piece), way = wayOf(x, piece);
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
  double no_length_ = 0;        ///< [m] below it a piece has none
  int sense_ = 0;               ///< in the step: 1 goes on, -1 goes back
  std::size_t most_at_once_ = 1;  ///< pieces, in the step
};

}  // namespace
}  // namespace stroma::lagrangian

STROMA_COMPONENT(sliding_lagrangian_constraint) {
  factory.add<stroma::lagrangian::Sliding>("SlidingLagrangianConstraint", "a point that slides along a line or a curve");
}
