// SPDX-License-Identifier: LGPL-2.1-or-later
// TwistConstraint: rigid frames that do not turn about some of their own axes, by their orientations alone.
//
//   q = s t,   t the twist about an axis a of the frame: the part w + (v.a) a of q = w + v, of length 1
//
// After each step the twists about x, y and z that are held, one after another, are taken out of the orientation, and those of
// the start are put in their place. Velocities stay as they are, also about the held axes: a torque makes them grow, and the
// frame shows the rest of the turn. FixedRotationProjectiveConstraint holds the velocities, and is what motion needs; the two are the same
// for a frame that turns about one axis.
//
// Source: what SOFA's FixedRotationProjectiveConstraint does; the attributes are its own.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-10"/>
//   <MechanicalObject template="Rigid3" position="0 0 0  0 0 0 1" velocity="0 0 0  1 2 3"/>
//   <UniformMass totalMass="1"/>
//   <TwistConstraint FixedXRotation="true"/>
// </Node>
#include <fmt/format.h>

#include "framework/mechanics/signs.h"
#include "framework/mechanics/position_constraint.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class TwistConstraint final : public PositionConstraint {
 public:
  void declare(DataTable& table) override {
    PositionConstraint::declare(table);
    table.add("FixedXRotation", held_[0]).help("no turn about x");
    table.add("FixedYRotation", held_[1]).help("no turn about y");
    table.add("FixedZRotation", held_[2]).help("no turn about z");
  }

  void init() override {
    PositionConstraint::init();
    if (!state().hasFrames())
      throw ComponentError("the nodes of " + state().path() + " have no orientation", "a state of template Rigid3");
    if (!held_[0] && !held_[1] && !held_[2])
      warn("no axis is fixed: the constraint has no effect", "FixedXRotation, FixedYRotation or FixedZRotation");
    kept_.clear();
    for (Index node = 1; node < state().size(); node += 2) {
      Quaternion left = turnedBy(state().position[std::size_t(node)]), kept = Quaternion::Identity();
      for (int axis = 0; axis < 3; ++axis)
        if (held_[axis]) kept = takeTwist(left, axis) * kept;
      kept_.push_back(kept);
    }
  }

  bool takesFrames() const override { return true; }
  void begin(const PositionStep&) override { is_done_ = false; }
  /// Once in a step: of several axes a second turn would change the orientation again.
  double correctPositions(const PositionStep&, Rows x, Rows reference) override {
    if (is_done_) return 0;
    is_done_ = true;
    for (std::size_t i = 0; i < kept_.size(); ++i) {
      const Index turn = row(Index(2 * i + 1));
      Quaternion left = orientationIn(x, turn);
      for (int axis = 0; axis < 3; ++axis)
        if (held_[axis]) takeTwist(left, axis);
      for (const Rows& rows : {x, reference}) putNearest(left * kept_[i], rows, turn);
    }
    return 0;
  }
  double correctVelocities(const PositionStep&, ConstRows, Rows) override { return 0; }
  std::string violation() const override { return {}; }
  std::string describe() const override { return fmt::format("{} frames keep their twists", kept_.size()); }

 private:
  /// q becomes s; returns t.
  static Quaternion takeTwist(Quaternion& q, int axis) {
    Quaternion twist(q.w(), 0, 0, 0);
    twist.vec()[axis] = q.vec()[axis];
    if (twist.squaredNorm() == 0) twist.setIdentity();
    twist.normalize();
    q = (q * twist.conjugate()).normalized();
    return twist;
  }

  bool held_[3] = {false, false, false};
  std::vector<Quaternion> kept_;  ///< of each frame, the twists of the start
  bool is_done_ = false;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(twist_constraint) {
  factory.add<stroma::TwistConstraint>("TwistConstraint", "Rigid frames whose orientations do not twist about some axes");
}
