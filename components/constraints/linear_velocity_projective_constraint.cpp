// SPDX-License-Identifier: LGPL-2.1-or-later
// LinearVelocityProjectiveConstraint: nodes whose velocity is given at key times, linear between them.
//
//   v(t) = w(t),   x(t) = x(t_0) + integral of w from t_0 to t
//
// with t_0 the start of the first step in which the velocities hold. Positions and velocities are exact at the end of
// every step. `coordinates` lists the axes that are driven (0, 1, 2; all when not given). Before the first key time the
// nodes are free, and after the last too, unless continueAfterEnd keeps the last velocity.
//
// Source: the attributes are SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-10"/>
//   <MechanicalObject position="0 0 0  1 0 0"/>
//   <UniformMass totalMass="0.3"/>
//   <SpringForceField springsIndices1="0" springsIndices2="1" lengths="1" stiffness="200"/>
//   <LinearVelocityProjectiveConstraint indices="0" keyTimes="0 1 2" velocities="0 0 0  0 1 0  0 0 0"/>
// </Node>
#include <fmt/format.h>

#include "components/constraints/held_nodes.h"
#include "framework/mechanics/key_times.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class LinearVelocityProjectiveConstraint final : public HeldNodes {
 public:
  void declare(DataTable& table) override {
    HeldNodes::declare(table);
    velocity_.declare(table, "velocities", "velocity of the nodes at each of keyTimes", "m/s");
    table.add("coordinates", axes_).help("axes that are driven (0, 1, 2); all when not given");
    table.add("continueAfterEnd", continue_).help("keep the last velocity after the last key time");
  }

  void init() override {
    HeldNodes::init();
    velocity_.check();
    if (data().find("coordinates")->isSet()) {
      if (axes_.empty()) throw ComponentError("coordinates lists no axis", "0, 1 or 2");
      projector_ = Mat3::Identity();
      for (int axis : axes_) {
        if (axis < 0 || axis > 2) throw ComponentError(fmt::format("coordinates lists the axis {}", axis), "0, 1 or 2");
        projector_(axis, axis) = 0;
      }
    }
    start_.reserve(nodes().size());
  }

  bool activeIn(double t, double t_end) const override {
    const bool after = continue_ && (t > velocity_.last() || sameTime(t, velocity_.last()));
    return ProjectiveConstraint::activeIn(t, t_end) && (after || velocity_.touches(t, t_end));
  }
  bool isConstant() const override { return false; }
  bool prescribesMotion() const override { return true; }
  void reset() override { start_.clear(); }
  void serialize(Archive& archive) override {
    archive.value("start_time", start_time_);
    serializeStart(archive, start_);
  }

  void beginMotion(double t, ConstRows x) override {
    if (!start_.empty()) return;
    start_time_ = std::max(t, velocity_.first());
    for (std::size_t i = 0; i < nodes().size(); ++i) start_.push_back(x[row(i)]);
  }

  void prescribe(double t, Rows x, Rows v) const override {
    const Mat3 held = Mat3::Identity() - projector_;
    const double until = continue_ ? t : std::min(t, velocity_.last());
    const Vec3 movement = velocity_.integral(start_time_, until), velocity = velocity_.at(t);
    for (std::size_t i = 0; i < nodes().size(); ++i) {
      x[row(i)] += held * (start_[i] + movement - x[row(i)]);
      v[row(i)] += held * (velocity - v[row(i)]);
    }
  }

 private:
  KeyTimes<Vec3> velocity_;
  std::vector<int> axes_;
  bool continue_ = false;
  double start_time_ = 0;    ///< [s]
  std::vector<Vec3> start_;  ///< [m], shape (nodes): positions at start_time_; empty until then
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(linear_velocity_projective_constraint) {
  factory.add<stroma::LinearVelocityProjectiveConstraint>("LinearVelocityProjectiveConstraint",
                                                          "Drives nodes with velocities given at times");
}
