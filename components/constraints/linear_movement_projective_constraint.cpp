// SPDX-License-Identifier: LGPL-2.1-or-later
// Nodes that follow movements given at key times, linear between them.
//
// LinearMovementProjectiveConstraint:
//   x(t) = x_0 + m(t)   (relativeMovements, the default), or   x(t) = m(t)
//   v(t) = m'(t), at a key time the slope before it
// PartialLinearMovementProjectiveConstraint: the same along the axes of movedDirections; the others are free. With cornerShares
//   a point makes the fraction s(X) of the movement, X its initial position. Along x, y and z s is linear between the corners of a
//   box from the origin to cornerBox: four in x and y, or eight, in the order of the nodes of cells.
//
// Of a rigid frame a movement has six numbers: of its centre, and a rotation vector r [rad] in fixed axes. Its orientation is
// exp(r(t)) q_0, or exp(r(t)), and its angular velocity dexp(r) r'. Nodes that are numbers have one number each.
//
// x_0 is the initial position if the movement is active from the start of the simulation, otherwise the position at its start.
// Positions and velocities are exact at the end of every step, whatever the integrator; inside a step the nodes move with
// constant velocity. A step that reaches past the last key ends at its movement.
//
// late="true" does what SOFA does: in the step that starts at t the nodes go to x(t), and in the equation of the step they
// have the velocity at its start, that after a key. Nodes of the partial constraint have v along all axes then, x_0 is the
// initial position, and cornerShares have no part in velocities.
//
// Before the first key and after the last the nodes are free, as in SOFA; with outside="hold" they stay at the first and the
// last position. If another constraint fixes a node in a direction of its movement, the node moves, and a warning is printed.
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

#include <algorithm>

#include "components/constraints/held_nodes.h"
#include "components/constraints/row_keys.h"
#include "framework/mechanics/start_velocity.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class LinearMovement : public HeldNodes, public StartVelocity {
 public:
  void declare(DataTable& table) override {
    HeldNodes::declare(table);
    movement_.declare(table, "movements", "displacement (or position) of the nodes at each of keyTimes", "m");
    table.add("relativeMovements", relative_).help("movements are displacements, else positions");
    table.addChoice("outside", outside_, {"free", "hold"})
        .help("state of the nodes before the first and after the last key time");
    table.add("late", late_).help("in a step the nodes go where they were to be at its start, with velocities of then, as SOFA's");
    table.addVisualOnly("showMovement");
  }

  void init() override {
    HeldNodes::init();
    holdAllRows();
    movement_.compile(state());
    if (outside_ == Outside::free && !data().find("outside")->isSet())
      inform(fmt::format("the nodes are free before t = {:g} s and after t = {:g} s; outside=\"hold\" fixes them",
                         movement_.first(), movement_.last()));
    start_.reserve(nodes().size() * std::size_t(heldRows()));
  }

  bool activeIn(double t, double t_end) const override {
    if (late_) {
      const bool is_early = t < movement_.first() && !sameTime(t, movement_.first());
      const bool is_over = t > movement_.last() || sameTime(t, movement_.last());
      return ProjectiveConstraint::activeIn(t, t_end) && (outside_ == Outside::hold || (!is_early && !is_over));
    }
    return ProjectiveConstraint::activeIn(t, t_end) && (outside_ == Outside::hold || movement_.touches(t, t_end));
  }
  bool keepsStartVelocity() const override { return late_; }
  void placeStart(double t, Rows x, Rows v) const override {
    if (late_ && activeIn(t, t)) prescribe(t, x, v);  // SOFA projects before the first step too
  }
  bool isConstant() const override { return outside_ == Outside::hold; }
  bool prescribesMotion() const override { return true; }
  void reset() override { start_.clear(); }
  void serialize(Archive& archive) override { serializeStart(archive, start_); }

  // A movement that is found under way, as when a run is resumed, has moved the nodes already.
  void beginMotion(double t, ConstRows x) override {
    if (!start_.empty()) return;
    const bool from_start = outside_ == Outside::hold || late_ || movement_.first() <= node().root().root_time;
    for (const Index node : nodes()) {
      const std::size_t own = start_.size();
      noteRows(state(), node, x, start_);
      for (Index k = 0; k < heldRows(); ++k) {
        Vec3& start = start_[own + std::size_t(k)];
        if (from_start) {
          start = state().position[std::size_t(node + k)];
        } else if (t > movement_.first()) {
          const Vec3 moved = share(own) * ((Mat3::Identity() - projector(k)) * movement_.of(k).at(t));
          start = turns(k) ? rotationVector(turnedBy(-moved) * turnedBy(start)) : Vec3(start - moved);
        }
      }
    }
  }

  void prescribe(double time, Rows x, Rows v) const override {
    constexpr double after = 1e-6;  // of a step: SOFA's velocity at a key is the one behind it
    const double lag = late_ ? node().dt() : 0;
    const double t = std::max(time - lag, std::min(time, node().root().root_time)), at_slope = t + after * lag;
    if (late_ && t < movement_.first() && !sameTime(t, movement_.first())) return;
    for (Index k = 0; k < heldRows(); ++k) {
      const Mat3 held = Mat3::Identity() - projector(k);
      // along the other axes numbers mean nothing, and a turn would take them along
      const Vec3 movement = turns(k) ? Vec3(held * movement_.of(k).at(t)) : movement_.of(k).at(t);
      const Vec3 slope = turns(k) ? Vec3(held * movement_.of(k).slope(at_slope)) : movement_.of(k).slope(at_slope);
      const Vec3 velocity = turns(k) ? angularVelocity(movement, slope) : slope;
      for (std::size_t i = 0; i < nodes().size(); ++i) {
        const Vec3& start = start_.empty() ? state().position[std::size_t(nodes()[i] + k)]
                                           : start_[i * std::size_t(heldRows()) + std::size_t(k)];
        Vec3 target = share(i) * movement;
        if (relative_) target = turns(k) ? rotationVector(turnedBy(movement) * turnedBy(start)) : Vec3(start + target);
        moveHeld(state().kindOf(k), target, held, x, row(i) + k);
        if (late_)
          v[row(i) + k] = velocity;
        else
          v[row(i) + k] += held * (share(i) * velocity - v[row(i) + k]);
      }
    }
  }

 protected:
  bool takesAllRows() const override { return true; }
  std::vector<double> shares_;  ///< of the movement that each point makes; empty: all of it

 private:
  enum class Outside : int { free, hold };

  double share(std::size_t i) const { return shares_.empty() ? 1 : shares_[i]; }

  bool turns(Index k) const { return state().kindOf(k) == RowKind::turn; }

  RowKeys movement_;
  bool relative_ = true, late_ = false;
  Outside outside_ = Outside::free;
  std::vector<Vec3> start_;  ///< rows of the nodes, as State::position has them; empty until the movement begins
};

class LinearMovementProjectiveConstraint final : public LinearMovement {};

class PartialLinearMovementProjectiveConstraint final : public LinearMovement {
 public:
  void declare(DataTable& table) override {
    LinearMovement::declare(table);
    table.add("movedDirections", directions_)
        .help("for x, y and z, of frames also for the turns about them, or for each number: 1 moved, 0 free");
    table.add("cornerShares", corner_shares_)
        .help("parts of the movement at four or eight corners of a box, linear between them; empty: all of it")
        .unit("-");
    table.add("cornerBox", box_).help("the corner of that box that is farthest from the origin").unit("m");
  }
  void init() override {
    LinearMovement::init();
    setProjectors(freeDirections(directions_, state(), "movedDirections"));
    if (std::none_of(directions_.begin(), directions_.end(), [](bool moved) { return moved; }))
      warn("movedDirections selects no direction: the constraint has no effect", "write 1 for each direction to move");
    if (!corner_shares_.empty()) findShares();
  }

 private:
  void findShares() {
    const std::size_t count = corner_shares_.size();
    if (count != 4 && count != 8) throw ComponentError(fmt::format("cornerShares has {} numbers", count), "four or eight");
    if (!state().hasPointsOnly()) throw ComponentError("cornerShares are of points", "a state of template Vec3");
    const int axes = count == 4 ? 2 : 3;
    if (!(box_.head(axes).minCoeff() > 0)) throw ComponentError("cornerBox has no size", "positive lengths");
    for (const Index node : nodes()) {
      const Vec3 xi = state().position[std::size_t(node)].cwiseQuotient(box_);
      double share = 0;
      for (std::size_t c = 0; c < count; ++c) {
        const bool high[3] = {c % 4 == 1 || c % 4 == 2, c % 4 >= 2, c >= 4};  // in the order of the nodes of cells
        double shape = corner_shares_[c];
        for (int axis = 0; axis < axes; ++axis) shape *= high[axis] ? xi[axis] : 1 - xi[axis];
        share += shape;
      }
      shares_.push_back(share);
    }
  }

  std::vector<double> corner_shares_;
  Vec3 box_ = Vec3::Zero();
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
