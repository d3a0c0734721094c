// SPDX-License-Identifier: LGPL-2.1-or-later
// Nodes that follow movements given at key times, linear between them.
//
// LinearMovementProjectiveConstraint:
//   x(t) = x_0 + m(t)   (relativeMovements, the default), or   x(t) = m(t)
//   v(t) = m'(t), at a key time the slope before it
// PartialLinearMovementProjectiveConstraint: the same along the axes of movedDirections; the others are free.
//
// x_0 is the initial position when the movement is under way from the start of the simulation, else the position where
// the movement begins. Positions and velocities are exact at the end of every step, whatever the integrator; inside a
// step the nodes move with constant velocity. A step that reaches past the last key ends at its movement.
//
// Before the first key and after the last the nodes are free, as in SOFA; with outside="hold" they stay where the first
// and the last movement put them.
//
// Source: the names and attributes are SOFA's, but for `outside`.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-10"/>
//   <MechanicalObject position="0 0 0  1 0 0  2 0 0"/>
//   <UniformMass totalMass="0.3"/>
//   <SpringForceField springsIndices1="0 1" springsIndices2="1 2" lengths="1 1" stiffness="200"/>
//   <LinearMovementProjectiveConstraint indices="0" keyTimes="0 1 2" movements="0 0 0  0 1 0  1 1 0" outside="hold"/>
//   <PartialLinearMovementProjectiveConstraint indices="2" keyTimes="0 1" movements="0 0 0  0.5 0 0"
//                                              movedDirections="1 0 0"/>
// </Node>
#include <fmt/format.h>

#include "components/constraints/held_nodes.h"
#include "framework/mechanics/key_times.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class LinearMovement : public HeldNodes {
 public:
  void declare(DataTable& table) override {
    HeldNodes::declare(table);
    movement_.declare(table, "movements", "displacement (or position) of the nodes at each of keyTimes", "m");
    table.add("relativeMovements", relative_).help("movements are displacements, else positions");
    table.addChoice("outside", outside_, {"free", "hold"})
        .help("what happens to the nodes before the first and after the last key time");
    table.addVisualOnly("showMovement");
  }

  void init() override {
    HeldNodes::init();
    movement_.check();
    if (outside_ == Outside::free && !data().find("outside")->isSet())
      inform(fmt::format("the nodes are free before t = {:g} s and after t = {:g} s; outside=\"hold\" keeps them",
                         movement_.first(), movement_.last()));
    start_.reserve(nodes().size());
  }

  bool activeIn(double t, double t_end) const override {
    return ProjectiveConstraint::activeIn(t, t_end) && (outside_ == Outside::hold || movement_.touches(t, t_end));
  }
  bool isConstant() const override { return outside_ == Outside::hold; }
  bool prescribesMotion() const override { return true; }
  void reset() override { start_.clear(); }
  void serialize(Archive& archive) override { serializeStart(archive, start_); }

  // A movement that is found under way, as when a run is resumed, has moved the nodes already.
  void beginMotion(double t, ConstRows x) override {
    if (!start_.empty()) return;
    const bool from_start = outside_ == Outside::hold || movement_.first() <= node().root().root_time;
    const Vec3 moved = t > movement_.first() ? movement_.at(t) : Vec3::Zero();
    for (std::size_t i = 0; i < nodes().size(); ++i)
      start_.push_back(from_start ? state().position[nodes()[i]] : Vec3(x[row(i)] - moved));
  }

  void prescribe(double t, Rows x, Rows v) const override {
    const Mat3 held = Mat3::Identity() - projector_;
    const Vec3 movement = movement_.at(t), velocity = movement_.slope(t);
    for (std::size_t i = 0; i < nodes().size(); ++i) {
      const Vec3 target = relative_ ? Vec3(start_[i] + movement) : movement;
      x[row(i)] += held * (target - x[row(i)]);
      v[row(i)] += held * (velocity - v[row(i)]);
    }
  }

 private:
  enum class Outside : int { free, hold };

  KeyTimes<Vec3> movement_;
  bool relative_ = true;
  Outside outside_ = Outside::free;
  std::vector<Vec3> start_;  ///< [m], shape (nodes); empty until the movement begins
};

class LinearMovementProjectiveConstraint final : public LinearMovement {};

class PartialLinearMovementProjectiveConstraint final : public LinearMovement {
 public:
  void declare(DataTable& table) override {
    LinearMovement::declare(table);
    table.add("movedDirections", directions_).help("for x, y and z: 1 moved, 0 free");
  }
  void init() override {
    LinearMovement::init();
    if (directions_.size() != 3)
      throw ComponentError(fmt::format("movedDirections has {} values", directions_.size()), "3 values");
    for (int c = 0; c < 3; ++c) projector_(c, c) = directions_[c] ? 0 : 1;
    if (projector_.isIdentity())
      warn("movedDirections moves no direction: the constraint does nothing", "write 1 for each direction to move");
  }

 private:
  std::vector<bool> directions_{true, true, true};
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(linear_movement_projective_constraint) {
  factory.add<stroma::LinearMovementProjectiveConstraint>("LinearMovementProjectiveConstraint",
                                                          "Moves nodes by displacements given at times");
  factory.add<stroma::PartialLinearMovementProjectiveConstraint>("PartialLinearMovementProjectiveConstraint",
                                                                 "Moves nodes along some of the axes");
}
