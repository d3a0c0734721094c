// SPDX-License-Identifier: LGPL-2.1-or-later
// AffineMovementProjectiveConstraint: nodes that move on straight lines to an affine image of their initial positions.
//
//   x(t) = (1 - s) X + s (A X + b),   s = (t - t_begin) / (t_end - t_begin) within [0, 1],   v = s' (A X + b - X)
//
// with X the initial positions, A the matrix `rotation` (nine numbers, row by row) times that of `quaternion` (x y z w), and b
// the `translation`. The nodes of `indices` are fixed before and after; those of `meshIndices` move between the two times and
// are free otherwise. Straight paths shrink a rotating body: half-way through a rotation by the angle a, lengths across its
// axis are cos(a/2) of their initial value.
//
// The centre of a rigid frame moves in the same way, and its orientation is exp(s r) q, r the rotation vector of A, which must
// then be a rotation.
//
// Source: the attributes are SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-10"/>
//   <MechanicalObject position="0 0 0  1 0 0  2 0 0"/>
//   <UniformMass totalMass="0.3"/>
//   <SpringForceField springsIndices1="0 1" springsIndices2="1 2" lengths="1 1" stiffness="200"/>
//   <AffineMovementProjectiveConstraint indices="0 2" beginConstraintTime="0" endConstraintTime="1"
//                                       rotation="0 -1 0  1 0 0  0 0 1" translation="0 0 0.5"/>
// </Node>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "components/constraints/held_nodes.h"
#include "framework/mechanics/frames.h"
#include "framework/mechanics/key_times.h"
#include "framework/mechanics/motion.h"
#include "framework/mechanics/node_indices.h"
#include "framework/mechanics/start_velocity.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class AffineMovementProjectiveConstraint final : public HeldNodes, public StartVelocity {
 public:
  void declare(DataTable& table) override {
    HeldNodes::declare(table);
    declareMatrix(table);
    table.add("meshIndices", guided_indices_).help("nodes that move along between the two times");
    table.add("beginConstraintTime", begin_).help("start of the movement").unit("s");
    table.add("endConstraintTime", end_).help("end of the movement").unit("s");
    table.add("rotation", rotation_).help("matrix applied to the positions, nine numbers row by row").unit("-");
    table.add("quaternion", quaternion_).help("rotation applied to the positions first, as x y z w").unit("-");
    table.add("translation", translation_).help("added last").unit("m");
    table.addChoice("velocity", velocity_, {"movement", "still"})
        .help("of the nodes: that of their movement, or zero, within steps too, as in SOFA");
    table.add("late", late_).help("in a step the nodes go where they were to be at its start, as SOFA's");
    table.addVisualOnly("drawConstrainedPoints");
  }

  void init() override {
    HeldNodes::init();
    if (!(end_ > begin_))
      throw ComponentError(
          fmt::format("endConstraintTime = {:g} is not after beginConstraintTime = {:g}", end_, begin_),
          "a later time");
    const Mat3 matrix = readMatrix();
    if (!state().hasPointsOnly()) holdFrames(matrix);
    if (data().find("meshIndices")->isSet()) {
      guided_ = checkedNodes(guided_indices_, state(), "meshIndices");
      std::erase_if(guided_, [this](Index node) { return std::binary_search(nodes().begin(), nodes().end(), node); });
    }
    path_.clear();
    for (const std::vector<Index>* list : {&nodes(), static_cast<const std::vector<Index>*>(&guided_)})
      for (Index node : *list) {
        const Vec3& start = state().position[node];
        path_.push_back({node, start, matrix * start + translation_});
      }
  }

  bool isConstant() const override { return guided_.empty(); }
  bool prescribesMotion() const override { return true; }
  bool keepsStartVelocity() const override { return velocity_ == Velocity::still; }

  void addProjectors(double t, std::vector<NodeProjector>& out) const override {
    for (std::size_t i = 0; i < movedAt(timeOf(t)); ++i)
      for (Index k = 0; k < heldRows(); ++k)
        out.push_back({state().firstRow() + path_[i].node + k,
                       leavesMatrix() && i < nodes().size() ? Mat3(Mat3::Identity()) : Mat3(Mat3::Zero())});
  }
  void placeStart(double t, Rows x, Rows v) const override {
    if (late_ && activeIn(t, t)) prescribe(t, x, v);  // SOFA projects before the first step too
  }
  void prescribe(double time, Rows x, Rows v) const override {
    const double t = timeOf(time);
    const bool moving = velocity_ == Velocity::movement && t > begin_ && (t < end_ || sameTime(t, end_));
    double s = std::clamp((t - begin_) / (end_ - begin_), 0., 1.);
    if (sameTime(t, end_)) s = 1;
    for (std::size_t i = 0; i < movedAt(t); ++i) {
      const Path& path = path_[i];
      x[state().firstRow() + path.node] = (1 - s) * path.from + s * path.to;
      v[state().firstRow() + path.node] = moving ? Vec3((path.to - path.from) / (end_ - begin_)) : Vec3::Zero();
      if (heldRows() == 1) continue;
      const Index turn = state().firstRow() + path.node + 1;
      placeRow(RowKind::turn, state().position[std::size_t(path.node + 1)], x, turn);
      Motion::turnBy(s * turn_, x.data + std::size_t(turn) * row_doubles);
      v[turn] = moving ? Vec3(turn_ / (end_ - begin_)) : Vec3::Zero();
    }
  }

 protected:
  bool takesAllRows() const override { return true; }

 private:
  struct Path {
    Index node;
    Vec3 from, to;
  };

  void holdFrames(const Mat3& matrix) {
    if (!state().hasFrames())
      throw ComponentError(fmt::format("the nodes of {} are numbers, which have no place", state().path()),
                           "points or rigid frames");
    if (!(matrix * matrix.transpose()).isIdentity(1e-6) || matrix.determinant() < 0)
      throw ComponentError("rotation is none, and frames cannot be stretched", "a rotation matrix");
    turn_ = rotationVector(Quaternion(matrix).normalized());
    holdAllRows();
  }

  Mat3 readMatrix() const {
    if (rotation_.size() != 9)
      throw ComponentError(fmt::format("rotation has {} numbers", rotation_.size()), "9 numbers");
    if (quaternion_.size() != 4)
      throw ComponentError(fmt::format("quaternion has {} numbers", quaternion_.size()), "4 numbers: x y z w");
    const Eigen::Quaterniond turn(quaternion_[3], quaternion_[0], quaternion_[1], quaternion_[2]);
    if (!(turn.norm() > 0)) throw ComponentError("quaternion is zero", "a unit quaternion");
    Mat3 matrix;
    for (int i = 0; i < 9; ++i) matrix(i / 3, i % 3) = rotation_[i];
    return matrix * turn.normalized().toRotationMatrix();
  }
  /// Of the movement, at a time of the simulation.
  double timeOf(double t) const { return late_ ? std::max(t - node().dt(), std::min(t, node().root().root_time)) : t; }
  /// How many of path_ move at the end t of a step: the guided nodes, which come last, only between the two times.
  std::size_t movedAt(double t) const {
    return t > begin_ && (t < end_ || sameTime(t, end_)) ? path_.size() : nodes().size();
  }

  std::vector<int> guided_indices_;
  std::vector<double> rotation_{1, 0, 0, 0, 1, 0, 0, 0, 1}, quaternion_{0, 0, 0, 1};
  Vec3 translation_ = Vec3::Zero(), turn_ = Vec3::Zero();  ///< turn_: r, of frames
  double begin_ = 0, end_ = 20;
  bool late_ = false;
  enum class Velocity : int { movement, still } velocity_ = Velocity::movement;
  std::vector<Index> guided_;
  std::vector<Path> path_;  ///< shape (nodes + guided nodes)
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(affine_movement_projective_constraint) {
  factory.add<stroma::AffineMovementProjectiveConstraint>("AffineMovementProjectiveConstraint",
                                                          "Moves nodes to an affine image of where they start");
}
