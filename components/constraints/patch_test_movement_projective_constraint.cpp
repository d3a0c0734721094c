// SPDX-License-Identifier: LGPL-2.1-or-later
// DirectionProjectiveConstraint: nodes that move along one direction only, from where they are. Velocities across it end.
//
//   P = d d^T,   d = direction / |direction|
//
// PatchTestMovementProjectiveConstraint: nodes on the border of a patch, moved with its corners.
//
//   x(t) = x_0 + s(t) u,   u = sum over corners c of N_c(x_0) cornerMovements[c],   s from 0 at begin to 1 at endConstraintTime
//
// N_c are the bilinear (trilinear) functions of four (eight) corners: the shares a = |x - x_c0| / |x_c1 - x_c0| along x, b along y from
// corner 0 to 3 and c along z from 0 to 4, in the order (0,0) (1,0) (1,1) (0,1), then the same at the far z. Without
// cornerPoints they are looked for among constrainedPoints. Before the movement and after it the nodes stand still. Their velocity
// is that of the movement, or zero with velocity="zero". In a step they have what takes them to its end; with velocity="still",
// as in SOFA, they have none there either, and their neighbours feel places alone.
//
// Source: names and attributes are SOFA's, but velocity.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-10"/>
//   <MechanicalObject position="0 0 0  2 0 0  2 2 0  0 2 0  0.7 1.2 0"/>
//   <UniformMass totalMass="1"/>
//   <SpringForceField springsIndices1="0 1 2 3" springsIndices2="4 4 4 4" lengths="1.3 1.7 1.5 1" stiffness="100"/>
//   <PatchTestMovementProjectiveConstraint indices="0 1 2 3" cornerPoints="0 0 0  2 0 0  2 2 0  0 2 0" endConstraintTime="1"
//     cornerMovements="0 0 0  0.1 0 0  0.1 0.1 0  0 0.1 0"/>
//   <DirectionProjectiveConstraint indices="4" direction="1 1 0"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "components/constraints/held_nodes.h"
#include "framework/mechanics/start_velocity.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class DirectionConstraint final : public HeldNodes {
 public:
  void declare(DataTable& table) override {
    HeldNodes::declare(table);
    declareMatrix(table);
    table.add("direction", direction_).help("along which the nodes move").unit("-").required();
  }
  void init() override {
    HeldNodes::init();
    if (!(direction_.norm() > 0)) throw ComponentError("direction is zero", "a vector that is not zero");
    const Vec3 d = direction_.normalized();
    setProjectors({d * d.transpose()});
  }
  bool projectsVelocity() const override { return true; }
  bool prescribesMotion() const override { return leavesMatrix(); }
  void placeStart(double t, Rows x, Rows v) const override {
    if (leavesMatrix() && activeIn(t, t)) prescribe(t, x, v);
  }
  void prescribe(double, Rows x, Rows v) const override {
    for (std::size_t i = 0; i < nodes().size(); ++i) {
      const Vec3& start = state().position[std::size_t(nodes()[i])];
      x[row(i)] = start + projector() * (x[row(i)] - start);
      v[row(i)] = (projector() * v[row(i)]).eval();
    }
  }

 private:
  Vec3 direction_ = Vec3::Zero();
};

class PatchTestMovement final : public HeldNodes, public StartVelocity {
 public:
  void declare(DataTable& table) override {
    HeldNodes::declare(table);
    declareMatrix(table);
    table.add("beginConstraintTime", begin_).help("when the movement begins").unit("s");
    table.add("endConstraintTime", end_).help("when it ends").unit("s");
    table.add("cornerPoints", corners_).help("four or eight corners").unit("m");
    table.add("cornerMovements", movements_).help("displacement of each corner").unit("m").required();
    table.add("constrainedPoints", points_).help("where corners are looked for when they are not given").unit("m");
    table.addChoice("velocity", velocity_, {"movement", "zero", "still"})
        .help("of the nodes: of their movement, zero, or zero within steps too, as in SOFA");
    table.add("late", late_).help("in a step the nodes go where they were to be at its start, as SOFA's");
    for (const char* name : {"meshIndices", "drawConstrainedPoints", "topology"}) table.addVisualOnly(name);
  }
  void init() override {
    HeldNodes::init();
    setProjectors({Mat3::Zero()});
    if (!(end_ > begin_)) throw ComponentError("the movement ends before it begins", "endConstraintTime after beginConstraintTime");
    if (corners_.empty()) findCorners();
    if (corners_.size() != 4 && corners_.size() != 8)
      throw ComponentError(fmt::format("there are {} corners", corners_.size()), "four or eight cornerPoints, or constrainedPoints");
    if (movements_.size() != corners_.size())
      throw ComponentError(fmt::format("cornerMovements has {} vectors for {} corners", movements_.size(), corners_.size()));
    for (int axis = 0; axis < (corners_.size() == 8 ? 3 : 2); ++axis)
      if (!(std::abs(corners_[far(axis)][axis] - corners_[0][axis]) > 0))
        throw ComponentError(fmt::format("corners 0 and {} have the same {}", far(axis), "xyz"[axis]), "corners of a box");
    movement_.clear();
    for (const Index node : nodes()) movement_.push_back(interpolated(state().position[std::size_t(node)]));
  }

  bool prescribesMotion() const override { return true; }
  bool keepsStartVelocity() const override { return velocity_ == Velocity::still; }
  void reset() override { start_.clear(); }
  void serialize(Archive& archive) override { serializeStart(archive, start_); }
  void placeStart(double t, Rows x, Rows v) const override {
    if (!late_ || !activeIn(t, t)) return;  // SOFA projects before the first step too
    for (std::size_t i = 0; i < nodes().size(); ++i) {
      x[row(i)] += shareAt(timeOf(t)) * movement_[i];
      v[row(i)] = Vec3(Vec3::Zero());
    }
  }
  // A movement that is found under way has moved the nodes already.
  void beginMotion(double t, ConstRows x) override {
    if (!start_.empty()) return;
    for (std::size_t i = 0; i < nodes().size(); ++i) start_.push_back(x[row(i)] - shareAt(timeOf(t)) * movement_[i]);
  }
  void prescribe(double time, Rows x, Rows v) const override {
    const double t = timeOf(time);
    const double share = shareAt(t);
    const bool moves = velocity_ == Velocity::movement && t > begin_ && t <= end_;
    for (std::size_t i = 0; i < nodes().size(); ++i) {
      x[row(i)] = start_[i] + share * movement_[i];
      v[row(i)] = moves ? Vec3(movement_[i] / (end_ - begin_)) : Vec3(Vec3::Zero());
    }
  }

 private:
  /// Of the movement, at a time of the simulation.
  double timeOf(double t) const { return late_ ? std::max(t - node().dt(), std::min(t, node().root().root_time)) : t; }
  double shareAt(double t) const { return std::clamp((t - begin_) / (end_ - begin_), 0., 1.); }
  static std::size_t far(int axis) { return axis == 0 ? 1 : axis == 1 ? 3 : 4; }
  Vec3 interpolated(const Vec3& p) const {
    std::array<double, 3> share{};
    for (int axis = 0; axis < (corners_.size() == 8 ? 3 : 2); ++axis)
      share[std::size_t(axis)] = std::abs(p[axis] - corners_[0][axis]) / std::abs(corners_[far(axis)][axis] - corners_[0][axis]);
    constexpr int at[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    Vec3 sum = Vec3::Zero();
    for (std::size_t c = 0; c < corners_.size(); ++c) {
      const double a = at[c % 4][0] ? share[0] : 1 - share[0], b = at[c % 4][1] ? share[1] : 1 - share[1];
      sum += a * b * (c < 4 ? 1 - share[2] : share[2]) * movements_[c];
    }
    return sum;
  }
  /// Each is the last point that lies beyond the one before in some of its directions, and far ones of even number beyond the near one
  /// along z, as SOFA looks for them.
  void findCorners() {
    if (points_.empty()) return;
    const bool solid = std::any_of(points_.begin(), points_.end(), [this](const Vec3& p) { return p[2] != points_[0][2]; });
    constexpr int signs[8][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}, {-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    corners_.assign(solid ? 8 : 4, points_[0]);
    for (const Vec3& p : points_)
      for (std::size_t c = 0; c < corners_.size(); ++c) {
        const bool beyond_z = c < 4 ? p[2] < corners_[c][2] : p[2] > corners_[c % 2 == 0 ? c - 4 : c][2];
        if (signs[c][0] * (p[0] - corners_[c][0]) > 0 || signs[c][1] * (p[1] - corners_[c][1]) > 0 || beyond_z) corners_[c] = p;
      }
  }
  double begin_ = 0, end_ = 20;
  bool late_ = false;
  std::vector<Vec3> corners_, movements_, points_;
  enum class Velocity : int { movement, zero, still } velocity_ = Velocity::movement;
  std::vector<Vec3> movement_, start_;  ///< of each node [m]
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(patch_test_movement_projective_constraint) {
  factory.add<stroma::DirectionConstraint>("DirectionProjectiveConstraint", "Lets nodes move along one direction only");
  factory.add<stroma::PatchTestMovement>("PatchTestMovementProjectiveConstraint", "Moves the border of a patch with its corners");
}
